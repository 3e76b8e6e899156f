"""Tables and figures of docs/evidence.md from the reports of `tendond validate`: `make evidence`."""

import shutil
import sys
from pathlib import Path

from tendond.offline.files import write_whole

BEGIN = "<!-- {name} -->"
END = "<!-- end -->"
NEXT = "\n## "
"""Begin of what the report says further, which the page leaves out."""


def renewed(text: str, reports: dict[str, str]) -> str:
    """Return the page with each data set's report, up to its second heading, between its two comments.

    Raises:
        ValueError: the page has no place for a report.
    """
    for name, report in reports.items():
        body = report.partition("\n\n")[2].partition(NEXT)[0].strip()
        begin = BEGIN.format(name=name)
        before, _, rest = text.partition(begin)
        _, end, after = rest.partition(END)
        if not end:
            raise ValueError(f"the page has no place for {name}: it needs one, {begin} to {END}")
        text = f"{before}{begin}\n\n{body}\n\n{end}{after}"
    return text


def main(folder: Path, page: Path, images: Path) -> None:
    """Write the page anew, and copy the figures."""
    reports = {one.stem: one.read_text(encoding="utf-8") for one in sorted(folder.glob("*.md"))}
    write_whole(page, renewed(page.read_text(encoding="utf-8"), reports))
    for name in reports:
        shutil.copyfile(folder / f"{name}.png", images / f"evidence-{name}.png")


if __name__ == "__main__":
    main(*(Path(one) for one in sys.argv[1:4]))
