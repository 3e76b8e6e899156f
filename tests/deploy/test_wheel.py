"""The wheel alone, in an empty environment and outside of the repository: described, complete, and the demo runs."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from email import message_from_string
from pathlib import Path

import pytest

from tendond import __version__
from tests.deploy.installation import ROOT, Distributions, build


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Distributions:
    return build(tmp_path_factory.mktemp("dist"))


@dataclass
class Environment:
    """An environment with the wheel, its declared dependencies and nothing else, and a folder to be in."""

    wheel: Path
    python: Path
    folder: Path

    def install(self, extra: str = "") -> None:
        """Install the wheel with an extra; its dependencies in the versions that are pinned."""
        pinned = self.folder.parent / "pinned.txt"
        pinned.write_text("\n".join(re.findall(r"^\S+==\S+", (ROOT / "requirements.txt").read_text(), re.M)))
        command = [sys.executable, "-m", "uv", "pip", "install", "-q", "--python", str(self.python), "-c", str(pinned)]
        subprocess.run([*command, f"{self.wheel}{extra}"], check=True, timeout=600)

    def tendond(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        settings = {name: value for name, value in os.environ.items() if name in ("HOME", "LANG", "PATH", "TMPDIR")}
        settings["NUMBA_CACHE_DIR"] = str(self.folder.parent / "kernels")
        command = [str(self.python.parent / "tendond"), *arguments]
        return subprocess.run(command, cwd=self.folder, env=settings, capture_output=True, text=True, timeout=1800)


@pytest.fixture(scope="module")
def environment(built: Distributions, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Environment]:
    base = tmp_path_factory.mktemp("clean")
    subprocess.run(
        [sys.executable, "-m", "uv", "venv", "-q", "--python", sys.executable, str(base / "venv")], check=True
    )
    (base / "elsewhere").mkdir()
    one = Environment(built.wheel, base / "venv" / "bin" / "python", base / "elsewhere")
    one.install()
    yield one
    shutil.rmtree(base)  # half a gigabyte


def test_the_wheel_says_what_it_is_whose_and_where_to_read_on(built: Distributions) -> None:
    with zipfile.ZipFile(built.wheel) as wheel:
        text = wheel.read(f"tendond-{__version__}.dist-info/METADATA").decode()
    metadata = message_from_string(text)
    assert metadata["Author"] == "tendond contributors"
    assert metadata["Description-Content-Type"] == "text/markdown"
    assert str(metadata.get_payload()).strip() == (ROOT / "README.md").read_text().strip()
    assert metadata.get_all("Project-URL") == ["Paper, https://arxiv.org/abs/2412.12035"]
    assert {"Typing :: Typed", "Operating System :: POSIX :: Linux"} <= set(metadata.get_all("Classifier") or ())
    assert len(metadata["Keywords"].split(",")) >= 5
    assert metadata["License-Expression"] == "Apache-2.0"


def test_the_demo_runs_without_extras_outside_of_the_repository_and_the_figures_come_with_the_extra(
    environment: Environment,
) -> None:
    ended = environment.tendond("demo", "--out", "demo")
    assert ended.returncode == 0, ended.stderr
    assert json.loads((environment.folder / "demo" / "summary.json").read_text())["settling_iterations"] > 0
    assert "pip install 'tendond[plot]', then tendond plot demo/demo.mcap" in ended.stdout
    assert not list(environment.folder.rglob("*.png"))
    assert "intact" in environment.tendond("log", "verify", "demo").stdout

    refused = environment.tendond("plot", "demo/demo.mcap")
    assert (refused.returncode, refused.stderr.count("\n")) == (2, 1)
    assert "pip install 'tendond[plot]'" in refused.stderr

    environment.install("[plot]")
    ended = environment.tendond("plot", "demo/demo.mcap", "--out", "figures")
    assert ended.returncode == 0, ended.stderr
    assert list((environment.folder / "figures").glob("*.png"))


def test_the_package_is_typed_and_its_version_that_of_its_code(environment: Environment) -> None:
    code = (
        "import importlib.metadata, importlib.resources, tendond\n"
        "print(tendond.__version__, importlib.metadata.version('tendond'),"
        " (importlib.resources.files('tendond') / 'py.typed').is_file())"
    )
    command = [str(environment.python), "-c", code]
    result = subprocess.run(command, cwd=environment.folder, env={}, capture_output=True, text=True, timeout=60)
    assert result.stdout == f"{__version__} {__version__} True\n", result.stderr
