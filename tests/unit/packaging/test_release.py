"""Release notes, citation, templates: what a release is published with."""

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

from tendond import __version__
from tendond.cli.manual.release import main, release_notes

ROOT = Path(__file__).parents[3]
CHANGES = """# Changelog

## [Unreleased]

- New.

## [1.2.0] - 2026-12-01

### Added

- Twelve.

## [1.1.0]

- Eleven.
"""


def test_the_notes_of_a_version_are_its_section_under_a_heading() -> None:
    assert release_notes(CHANGES, "1.2.0") == "# tendond 1.2.0, 2026-12-01\n\n### Added\n\n- Twelve.\n"
    assert release_notes(CHANGES, "unreleased") == "# tendond Unreleased\n\n- New.\n"


@pytest.mark.parametrize(("version", "said"), [("9.9.9", "has no section"), ("1.1.0", "has no date")])
def test_a_version_that_was_not_released_has_no_notes(version: str, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        release_notes(CHANGES, version)


def test_the_command_prints_notes_the_version_of_the_documentation_or_a_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["unreleased"]) == 0
    assert capsys.readouterr().out.startswith("# tendond Unreleased\n\n### Added\n")
    assert main(["--minor"]) == 0
    assert capsys.readouterr().out.strip() == __version__.rpartition(".")[0]
    assert main(["9.9.9"]) == 1
    assert re.fullmatch(r"tendond: .*\n", capsys.readouterr().err)
    assert main(["1", "2", "3"]) == 1


def test_the_citation_has_what_its_format_requires() -> None:
    """By the format's guide, version 1.2.0; docs/releases.md has the command that validates it by the schema."""
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= set(cited)
    assert cited["cff-version"] == "1.2.0"
    assert cited["version"] == __version__
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert [author["name"] for author in cited["authors"]] == [author["name"] for author in project["authors"]]
    assert cited["license"] == project["license"]
    (paper,) = cited["references"]
    assert {"type", "title", "authors", "year", "doi"} <= set(paper)


def test_the_paper_has_one_year_everywhere() -> None:
    (paper,) = yaml.safe_load((ROOT / "CITATION.cff").read_text())["references"]
    year = str(paper["year"])
    number = paper["doi"].rpartition("arXiv.")[2]
    assert number.startswith(year[2:]), "a number of arXiv begins with the year"
    found = 0
    for path in [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("schemas/**/*.py")]:
        text = path.read_text(encoding="utf-8")
        near = re.findall(rf"{re.escape(number)}\)?,? \(?(20\d\d)|Janabi-Sharifi,? (20\d\d)", text)
        for years in near:
            found += 1
            assert set(years) - {""} == {year}, path
    assert found >= 5


def test_the_templates_of_issues_are_forms_with_unique_fields() -> None:
    forms = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("[!c]*.yml"))
    assert len(forms) == 2
    for path in forms:
        form = yaml.safe_load(path.read_text())
        assert {"name", "description", "body"} <= set(form)
        fields = [one for one in form["body"] if one["type"] != "markdown"]
        assert len({one["id"] for one in fields}) == len(fields)
        assert all(one["attributes"]["label"] for one in fields)
        assert any(one.get("validations", {}).get("required") for one in fields)


def test_what_the_templates_and_policies_name_exists() -> None:
    for name in ("SECURITY.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md", ".github/pull_request_template.md"):
        text = (ROOT / name).read_text()
        for target in re.findall(r"\]\(([\w./-]+)\)|`([\w-]+/[\w./-]+)`", text):
            assert (ROOT / (target[0] or target[1])).exists(), f"{name}: {target}"


def test_an_editable_installation_is_found_from_the_folder_above_the_clone(tmp_path: Path) -> None:
    """There, `tendond/` is the clone: a folder without __init__.py, which must not hide the package."""
    build = "import sys; from setuptools import build_meta; print(build_meta.build_editable(sys.argv[1]))"
    folder = tmp_path / "wheel"
    folder.mkdir()
    subprocess.run([sys.executable, "-c", build, str(folder)], cwd=ROOT, check=True, capture_output=True, timeout=120)
    (wheel,) = folder.glob("*.whl")
    subprocess.run([sys.executable, "-m", "zipfile", "-e", str(wheel), str(tmp_path / "site")], check=True)
    (tmp_path / "tendond").symlink_to(ROOT)
    code = f"import site; site.addsitedir({str(tmp_path / 'site')!r}); import tendond; print(tendond.__version__)"
    for flags in (("-S",), ("-S", "-P")):
        command = [sys.executable, *flags, "-c", code]
        result = subprocess.run(command, cwd=tmp_path, env={}, capture_output=True, text=True, timeout=60)
        assert result.stdout == f"{__version__}\n", result.stderr
