"""Installation of this tree below a folder, as a package's build does it."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SURROUNDINGS = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
"""Environment of this process, without a path to the working copy: what is installed is to be run."""


def tool(name: str, package: str) -> str:
    """Return a program of the machine; without it the test is skipped, but not in CI, which installs it."""
    found = shutil.which(name)
    if found is None:
        assert not os.environ.get("CI"), f"no {name}: .ci/run must install Debian's {package}"
        pytest.skip(f"no {name}: apt install {package}")
    return found


@dataclass
class Installation:
    """Installation below a folder."""

    source: Path
    wheel: Path
    root: Path

    def run(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"  # has uv, which is faster than pip
        settings = {"DESTDIR": str(self.root), "PATH": path, "UV_COMPILE_BYTECODE": "0"}
        command = [str(self.source / "deploy" / "install"), *arguments]
        return subprocess.run(
            command, env={**SURROUNDINGS, **settings}, cwd=self.source, capture_output=True, text=True, timeout=600
        )

    def install(self) -> "subprocess.CompletedProcess[str]":
        options = ("--python", sys.executable, "--wheel", str(self.wheel), "--rig", "bench", "--rig", "arm")
        return self.run("install", *options)

    def tendond(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run the installed program in a folder with a trap in it: code in the current folder must not be run."""
        trap = self.root / "trap"
        (trap / "tendond").mkdir(parents=True, exist_ok=True)
        (trap / "tendond" / "__init__.py").write_text("raise SystemExit('the code in the current folder was run')\n")
        program = str(self.root / "opt/tendond/bin/tendond")
        command = [program, *arguments]
        return subprocess.run(command, env=SURROUNDINGS, cwd=trap, capture_output=True, text=True, timeout=300)


@dataclass(frozen=True)
class Distributions:
    """Both distributions of a tree, and the source distribution unpacked."""

    source: Path
    wheel: Path


def build(folder: Path, tree: Path = ROOT) -> Distributions:
    """Build both distributions of a tree into a folder, and unpack the source."""
    command = [sys.executable, "-m", "uv", "build", "-q", "--no-build-isolation", "--python", sys.executable]
    subprocess.run([*command, "-o", str(folder), str(tree)], check=True, timeout=300)
    (archive,) = folder.glob("*.tar.gz")
    subprocess.run(["tar", "-xf", str(archive), "-C", str(folder)], check=True)
    (wheel,) = folder.glob("*.whl")
    return Distributions(folder / archive.name.removesuffix(".tar.gz"), wheel)


def build_and_install(folder: Path, tree: Path = ROOT) -> Installation:
    """Build both distributions of a tree, unpack the source, and install it from there."""
    built = build(folder, tree)
    one = Installation(built.source, built.wheel, folder / "root")
    result = one.install()
    assert result.returncode == 0, result.stderr
    return one
