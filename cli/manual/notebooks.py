"""`python -m tendond.cli.manual.notebooks FOLDER OUT IMAGES`: run the notebooks of a folder, and write each as a page.

A notebook runs as a user would run it: in an empty folder, with tendond installed. Needs the extra `dev`.
"""

import base64
import os
import re
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SECONDS_MAX = 600
"""Time that a cell may take, kernels to be compiled included [s]."""

NOTE = "*This page is the notebook [{name}.ipynb]({name}.ipynb), with its results. `make notebooks` runs it again.*\n"
ESCAPES = re.compile(r"\x1b\[\??[0-9;]*[A-Za-z]")
PROGRESS = re.compile(r"[━╸╺⠋⠙⠹⠸⠼⠴⠦⠧⠇⠏]")
"""Parts of a progress bar or a spinner."""


def execute(source: Path) -> Any:
    """Run a notebook in an empty folder; return it with its results.

    Raises:
        CellExecutionError: a cell failed, with its traceback.
    """
    import nbformat
    from nbclient import NotebookClient
    from traitlets.config import Config

    notebook = nbformat.read(source, as_version=4)
    programs = str(Path(sys.executable).parent)  # `tendond` is that of this interpreter
    path = os.environ.get("PATH", "")
    with tempfile.TemporaryDirectory() as folder:
        settings = Path(folder) / ".settings"
        environment = {
            **os.environ,
            "PATH": f"{programs}:{path}",
            "COLUMNS": "120",
            "NO_COLOR": "1",
            "IPYTHONDIR": str(settings),
        }
        settings.mkdir()
        sockets = Config({"KernelManager": {"transport": "ipc", "ip": str(settings / "kernel")}})  # no port
        place = {"metadata": {"path": folder}}
        NotebookClient(notebook, timeout=SECONDS_MAX, kernel_name="python3", resources=place, config=sockets).execute(
            env=environment
        )
    return notebook


def page(notebook: Any, name: str, images: Path, link: str) -> str:
    """Return an executed notebook as Markdown, and write its pictures.

    Args:
        notebook: the notebook. name: its name.
        images: folder for the pictures: `notebook-NAME-1.png` and so on.
        link: path from the page to that folder.
    """
    for old in images.glob(f"notebook-{name}-*.png"):
        old.unlink()
    parts: list[str] = []
    pictures = 0
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```ipython\n{cell.source}\n```")
        for kind, content in _outputs(cell):
            if kind == "image/png":
                pictures += 1
                file = f"notebook-{name}-{pictures}.png"
                (images / file).write_bytes(base64.b64decode(content))
                parts.append(f"![Result of the cell above]({link}/{file})")
            elif kind == "text/html":
                parts.append(f'<div class="result">{_in_one_block(content)}</div>')
            else:
                parts.append(f"```text\n{_lasting(content)}\n```")
    heading, *rest = parts[0].split("\n", 1)
    return "\n\n".join([heading, NOTE.format(name=name).strip(), *(text.strip() for text in rest), *parts[1:]]) + "\n"


def _outputs(cell: Any) -> Iterator[tuple[str, str]]:
    """Yield the results of a cell: the richest form of each, and all that it printed as one text."""
    streams = [output for output in cell.outputs if output.output_type == "stream"]
    printed = "".join(stream.text for stream in streams if stream.name == "stdout")
    if printed:
        yield "text/plain", printed
    for output in cell.outputs:
        if output.output_type in ("display_data", "execute_result"):
            kind = next(one for one in ("image/png", "text/html", "text/plain") if one in output.data)
            yield kind, output.data[kind]


def _lasting(printed: str) -> str:
    """Return what a terminal shows in the end: of a line that is written over the last text, of progress nothing."""
    lines = [re.split(r"\r(?!\n)|\x1b\[2K", line.rstrip("\r"))[-1] for line in printed.split("\n")]
    lines = [ESCAPES.sub("", line).rstrip() for line in lines]
    return "\n".join(line for line in lines if not PROGRESS.search(line)).strip()


def _in_one_block(html: str) -> str:
    """Return HTML without the styles of pandas, which the site has of its own, and without blank lines and indents,
    which would end it for Markdown."""
    html = re.sub(r"<style.*?</style>", "", html, flags=re.DOTALL)
    return "\n".join(line.strip() for line in html.splitlines() if line.strip())


def main(folder: Path, out: Path, images: Path) -> None:
    """Run the notebooks of a folder, and write the pages."""
    for path in (out, images):
        path.mkdir(parents=True, exist_ok=True)
    link = Path(os.path.relpath(images, out)).as_posix()
    for source in sorted(folder.glob("*.ipynb")):
        text = page(execute(source), source.stem, images, link)
        (out / f"{source.stem}.md").write_text(text, encoding="utf-8")
        print(out / f"{source.stem}.md", flush=True)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]))
