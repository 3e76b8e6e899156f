"""The pages about the repository itself name what is there: folders, functions, tests, renamed things."""

import ast
import itertools
import re
import shlex
from pathlib import Path

import pytest

from tendond import __version__
from tendond.cli.manual.site import GENERATED
from tendond.cli.program import MOVED
from tendond.schemas.config.renamed import IN_SECONDS, REMOVED, RENAMED

ROOT = Path(__file__).parents[3]
ARCHITECTURE = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
DOCUMENTS = [ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/**/*.md")]
FUNCTIONS = re.findall(r"`([\w/]+\.py):([\w.]+)", ARCHITECTURE)
PYTEST = re.compile(r"`pytest ([^`]+)`")


def definitions(path: Path) -> set[str]:
    """Names of the functions and classes of a file, methods as Class.method."""
    names = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            names |= {f"{node.name}.{one.name}" for one in node.body if isinstance(one, ast.FunctionDef)}
    return names


def test_the_path_of_a_pose_has_steps() -> None:
    assert len(FUNCTIONS) >= 8


@pytest.mark.parametrize(("path", "name"), FUNCTIONS)
def test_every_function_on_the_path_of_a_pose_exists(path: str, name: str) -> None:
    assert name in definitions(ROOT / path)


def test_the_architecture_fits_on_a_screen_and_names_every_linked_folder() -> None:
    assert len(ARCHITECTURE.splitlines()) <= 70
    for link in (ROOT / "tendond").iterdir():
        if link.is_symlink():
            assert f"{link.name}/" in ARCHITECTURE
            assert f"{link.name}/" in (ROOT / "docs/decisions/0005-layout.md").read_text(encoding="utf-8")


def test_the_changelog_names_every_renamed_command_and_key() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    renamed = text[text.index("### Renamed") :]
    for old, moved in MOVED.items():
        assert old in renamed
        assert moved.now.split(" --")[0] in renamed
    for (section, old), new in (RENAMED | IN_SECONDS).items():
        assert re.search(rf"\b{old}\b", renamed), f"{section}.{old}"
        assert re.search(rf"\b{new}\b", renamed), f"{section}.{new}"
    for section, old in REMOVED:
        assert f"{section}.{old}" in renamed


def test_the_citation_is_of_this_version() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {__version__}\n" in citation
    doi = re.search(r"doi: (\S+)", citation)
    assert doi is not None
    assert doi[1] in (ROOT / "README.md").read_text(encoding="utf-8")


def selections() -> list[tuple[str, str]]:
    """Each `pytest ...` in the documents, with the page that it stands on."""
    return [(path.name, found[1]) for path in DOCUMENTS for found in PYTEST.finditer(path.read_text(encoding="utf-8"))]


@pytest.mark.parametrize(("page", "line"), selections())
def test_the_tests_that_the_documents_name_exist(page: str, line: str) -> None:
    words = shlex.split(line)
    files = [ROOT / word for word in words if word.startswith("tests/")]
    assert files
    texts = [(one if one.is_file() else one / "__init__.py").read_text(encoding="utf-8") for one in files]
    chosen = [after for before, after in itertools.pairwise(words) if before == "-k"]
    for name in re.findall(r"[\w.]+", " ".join(chosen)):
        if name not in ("or", "and", "not"):
            assert any(name in text for text in texts), name


LINK = re.compile(r"\]\(([^)\s#]+)(?:#[^)]*)?\)")
CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_link_leads_to_a_file_where_the_repository_itself_is_read(path: Path) -> None:
    for target in LINK.findall(CODE.sub("", path.read_text(encoding="utf-8"))):
        if "://" not in target and not target.startswith("mailto:"):
            assert (path.parent / target).exists(), target


def test_a_page_that_the_documentation_generates_says_so_in_the_repository() -> None:
    for uri in GENERATED:
        assert "make docs" in (ROOT / "docs" / uri).read_text(encoding="utf-8")
