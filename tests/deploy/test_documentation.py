"""The documentation of several versions in a branch, as `make docs-version` puts it there, tried in a clone."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.deploy.installation import ROOT


@pytest.fixture(scope="module")
def clone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clone of what is committed."""
    if not (ROOT / ".git").exists():
        pytest.skip("not a git repository")
    folder = tmp_path_factory.mktemp("clone") / "tendond"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(folder)], check=True, timeout=120)
    return folder


def run(clone: Path, *command: str) -> str:
    """Run a command in the clone with the tools of this environment."""
    roles = ("AUTHOR_NAME", "AUTHOR_EMAIL", "COMMITTER_NAME", "COMMITTER_EMAIL")
    names = {f"GIT_{role}": "tests@example.org" for role in roles}
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    settings = {**os.environ, **names, "PATH": path, "PYTHONPATH": str(clone), "NO_MKDOCS_2_WARNING": "1"}
    result = subprocess.run(command, cwd=clone, env=settings, capture_output=True, text=True, timeout=600)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_each_version_has_a_folder_and_the_selector_lists_them_newest_first(clone: Path) -> None:
    run(clone, "mike", "deploy", "--update-aliases", "0.1", "latest")
    run(clone, "mike", "deploy", "--update-aliases", "0.2", "latest")
    run(clone, "mike", "set-default", "latest")
    listed = json.loads(run(clone, "git", "show", "gh-pages:versions.json"))
    assert [(one["version"], one["aliases"]) for one in listed] == [("0.2", ["latest"]), ("0.1", [])]
    for version in ("0.1", "0.2"):
        page = run(clone, "git", "show", f"gh-pages:{version}/index.html")
        assert '"version": {"provider": "mike"}' in page
    assert "latest/" in run(clone, "git", "show", "gh-pages:index.html")
    assert run(clone, "git", "status", "--porcelain") == "", "the working copy stays as it is"


def test_the_target_does_that_with_the_version_of_the_package(clone: Path) -> None:
    makefile = (ROOT / "Makefile").read_text()
    recipe = re.search(r"^docs-version: docs .*\n((?:\t.*\n)+)", makefile, re.M)
    assert recipe is not None
    assert "mike deploy --update-aliases" in recipe[1]
    assert "mike set-default latest" in recipe[1]
    assert re.fullmatch(r"\d+\.\d+\n", run(clone, sys.executable, "-m", "tendond.cli.manual.release", "--minor"))
