"""Links out of the documentation: a file of the repository that a page links to becomes a page of the site."""

import posixpath
import re
from collections.abc import Callable
from pathlib import Path

DOCS = "docs/"
SOURCE = "source/"
ROOT_PAGES = {
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
}
LANGUAGES = {
    ".json5": "js",
    ".md": "markdown",
    ".py": "python",
    ".sh": "sh",
    ".toml": "toml",
    ".json": "json",
    ".txt": "text",
}
MAX_SHOWN = 20
"""Things in a folder, beyond which its page only lists them."""

_LINK = re.compile(r"(\[[^\]]*\]\()([^)\s#]+)((?:#[^)]*)?\))")


def site_path(repository: Path, path: str) -> str | None:
    """Return the page of a file or folder of the repository; none if it does not exist."""
    if path in ROOT_PAGES:
        return ROOT_PAGES[path]
    if path.startswith(DOCS) and not (repository / path).is_dir():
        return path.removeprefix(DOCS)
    return f"{SOURCE}{path}.md" if path and (repository / path).exists() else None


def with_links(text: str, repository: Path, folder: str, page: str, note: Callable[[str], None]) -> str:
    """Markdown whose links lead to the site.

    Args:
        text: text of a page.
        repository: its folder.
        folder: the page's folder in the repository, to which its links are relative.
        page: the page in the site that the text becomes.
        note: called with each file and folder of the repository that a link leads to, outside the documentation.
    """

    def lead(match: re.Match[str]) -> str:
        before, target, after = match.groups()
        if "://" in target or target.startswith("mailto:"):
            return match[0]
        path = posixpath.normpath(posixpath.join(folder, target))
        there = site_path(repository, path)
        if there is None:
            return match[0]  # mkdocs will complain of it
        if there.startswith(SOURCE):
            note(path)
        return f"{before}{posixpath.relpath(there, posixpath.dirname(page) or '.')}{after}"

    parts = re.split(r"(^```.*?^```[^\n]*$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if index % 2 else _LINK.sub(lead, part) for index, part in enumerate(parts))


def source_page(repository: Path, path: str) -> tuple[str, str]:
    """Make a page of a file, or of a folder its README and contents; return the folder of its links, too."""
    place = repository / path
    head = f"---\nsearch:\n  exclude: true\n---\n\n# `{path}`\n\n"
    if place.is_file():
        language = LANGUAGES.get(place.suffix, "text")
        return f"{head}~~~~~~~~{language}\n{place.read_text(encoding='utf-8')}\n~~~~~~~~\n", path
    names = sorted(f"{one.name}/" if one.is_dir() else one.name for one in place.iterdir() if one.name[0] not in "._")
    shown = {name for name in names if Path(name).suffix in LANGUAGES and len(names) <= MAX_SHOWN}
    readme = place / "README.md"
    text = re.sub(r"^# .*\n", "", readme.read_text(encoding="utf-8"), count=1) if readme.is_file() else ""
    listing = "\n".join(f"- [`{name}`]({name})" if name in shown else f"- `{name}`" for name in names)
    return f"{head}{text}\n\nIn here:\n\n{listing}\n", path
