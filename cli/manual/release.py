"""The notes of a release, from CHANGELOG.md: `make notes`, or `python -m tendond.cli.manual.release [VERSION]`.

Without a version those of this one; `unreleased` prints what has changed since. With --minor it prints major and minor
number of this version, under which its documentation is published.
"""

import re
import sys
from pathlib import Path

from tendond import __version__

CHANGELOG = Path(__file__).resolve().parents[2] / "CHANGELOG.md"
_HEADING = re.compile(r"^## \[(?P<version>[^]]+)\](?: - (?P<date>\d{4}-\d{2}-\d{2}))?$", re.M)


def release_notes(text: str, version: str) -> str:
    """Return the section of a version, in Markdown, under a heading of its own.

    Args:
        text: of the changelog.
        version: as in its headings; `unreleased` in any case.

    Raises:
        ValueError: it has no such section, or one without a date that is not `Unreleased`.
    """
    headings = list(_HEADING.finditer(text))
    for heading, end in zip(headings, [*(one.start() for one in headings[1:]), len(text)], strict=True):
        if heading["version"].casefold() == version.casefold():
            if heading["date"] is None and version.casefold() != "unreleased":
                raise ValueError(f"the heading of {version} has no date: write ## [{version}] - YYYY-MM-DD")
            date = f", {heading['date']}" if heading["date"] else ""
            return f"# tendond {heading['version']}{date}\n\n{text[heading.end() : end].strip()}\n"
    known = ", ".join(heading["version"] for heading in headings)
    raise ValueError(f"CHANGELOG.md has no section [{version}]; it has {known}")


def main(arguments: list[str]) -> int:
    """Print what was asked for; return the exit status."""
    if arguments == ["--minor"]:
        print(".".join(__version__.split(".")[:2]))
        return 0
    try:
        print(release_notes(CHANGELOG.read_text(encoding="utf-8"), *(arguments or [__version__])), end="")
    except (OSError, TypeError, ValueError) as error:
        print(f"tendond: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
