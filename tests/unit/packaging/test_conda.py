"""deploy/conda/recipe.yaml has the version, the requirements and the program of pyproject.toml."""

import re
import tomllib
from pathlib import Path
from typing import Any

import yaml

from tendond import __version__

ROOT = Path(__file__).parents[3]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
CONDA_NAMES = {"matplotlib": "matplotlib-base", "opencv-python-headless": "py-opencv"}
"""Names of packages that conda-forge has under another one."""

UNPACKAGED = {"vicon-sdk"}
"""Extras that no conda package can have: their library is a vendor's."""


def recipe() -> Any:
    """The recipe with its context filled in, as rattler-build does it."""
    text = (ROOT / "deploy" / "conda" / "recipe.yaml").read_text()
    context = yaml.safe_load(text)["context"]
    filled = re.sub(r"\$\{\{ (\w+) }}", lambda found: str(context.get(found[1], found[0])), text)
    return yaml.safe_load(filled)


def wanted(requirements: list[str]) -> set[str]:
    """Requirements of pyproject.toml as conda writes them."""
    found = set()
    for one in requirements:
        match = re.fullmatch(r"([\w-]+)(.*)", one)
        assert match is not None
        found.add(f"{CONDA_NAMES.get(match[1], match[1])} {match[2]}")
    return found


def test_the_version_is_that_of_the_package() -> None:
    assert recipe()["package"] == {"name": "tendond", "version": __version__}


def test_what_it_requires_is_what_the_package_requires() -> None:
    project = PROJECT["project"]
    python = f"python {project['requires-python']}"
    run = recipe()["requirements"]["run"]
    assert set(run) == wanted(project["dependencies"]) | {python, "__linux"}
    extras = [
        one
        for name, requirements in project["optional-dependencies"].items()
        for one in requirements
        if name not in {"dev", *UNPACKAGED}
    ]
    assert set(recipe()["requirements"]["run_constraints"]) == wanted(extras)
    host = {one.replace(" ", "") for one in recipe()["requirements"]["host"]}
    assert set(PROJECT["build-system"]["requires"]) | {python.replace(" ", ""), "pip"} == host


def test_it_installs_the_program_and_runs_it() -> None:
    found = recipe()
    (script,) = found["build"]["python"]["entry_points"]
    name, target = script.split(" = ")
    assert PROJECT["project"]["scripts"] == {name: target}
    assert any("tendond --version" in one.get("script", ()) for one in found["tests"])
    assert found["about"]["license"] == PROJECT["project"]["license"]
    assert found["about"]["summary"] == PROJECT["project"]["description"]
    assert (ROOT / "deploy" / "conda" / found["source"]["path"]).resolve() == ROOT
