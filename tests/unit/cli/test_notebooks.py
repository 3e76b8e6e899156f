"""The notebooks of the documentation run, and their pages are theirs."""

import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest

from tendond.cli.manual.notebooks import page

ROOT = Path(__file__).parents[3]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
RESULT = re.compile(r"!\[Result of the cell above\]|<div class=\"result\">|^```text$", re.MULTILINE)


def cells(text: str) -> list[str]:
    """Every block of code of a page."""
    return re.findall(r"^```ipython\n(.*?)\n```$", text, re.MULTILINE | re.DOTALL)


def results(text: str) -> list[str]:
    """The kinds of results of a page, in their order."""
    return RESULT.findall(text)


def test_there_are_three_notebooks() -> None:
    assert {path.stem for path in NOTEBOOKS} == {"see-a-run", "write-a-law", "identify"}


@pytest.mark.parametrize("source", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_kept_without_results_and_its_page_has_its_cells(source: Path) -> None:
    notebook = nbformat.read(source, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert not any(cell.outputs or cell.execution_count for cell in code)
    text = source.with_suffix(".md").read_text(encoding="utf-8")
    assert cells(text) == [cell.source for cell in code], "run `make notebooks`"
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            assert cell.source.split("\n", 2)[-1].strip() in text, "run `make notebooks`"
    assert results(text)


@pytest.mark.parametrize("source", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_as_a_user_runs_it(source: Path, tmp_path: Path) -> None:
    """In a process of its own, in an empty folder; with the kinds of results that its page shows."""
    folder = tmp_path / "notebooks"
    folder.mkdir()
    (folder / source.name).write_bytes(source.read_bytes())
    command = [sys.executable, "-m", "tendond.cli.manual.notebooks", folder, tmp_path / "pages", tmp_path / "images"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=900)
    assert done.returncode == 0, done.stderr[-3000:]
    text = (tmp_path / "pages" / f"{source.stem}.md").read_text(encoding="utf-8")
    shown = source.with_suffix(".md").read_text(encoding="utf-8")
    assert results(text) == results(shown), "run `make notebooks`"
    assert str(ROOT) not in text
    pictures = re.findall(r"\]\(\.\./images/(.*?)\)", text)
    assert all((tmp_path / "images" / name).read_bytes().startswith(b"\x89PNG") for name in pictures)


def test_of_what_a_terminal_shows_a_page_has_what_stays(tmp_path: Path) -> None:
    printed = "\x1b[2K⠋ reading\x1b[2K⠙ reading\r\n\x1b[1mE\x1b[0m   1.7e11\r\nround 1 ━━━ 2/2\nold\rnew\n"
    output = SimpleNamespace(output_type="stream", name="stdout", text=printed)
    heading = SimpleNamespace(cell_type="markdown", source="# Title\n\nText.")
    code = SimpleNamespace(cell_type="code", source="!command", outputs=[output])
    text = page(SimpleNamespace(cells=[heading, code]), "name", tmp_path, "images")
    assert text.startswith("# Title\n\n*This page is the notebook [name.ipynb]")
    assert text.endswith("```ipython\n!command\n```\n\n```text\nE   1.7e11\nnew\n```\n")
