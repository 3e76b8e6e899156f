"""Installation of this tree below a folder, as a package's build does it."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


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
            command, env={**os.environ, **settings}, cwd=self.source, capture_output=True, text=True, timeout=600
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
        return subprocess.run([program, *arguments], cwd=trap, capture_output=True, text=True, timeout=300)


def build_and_install(folder: Path) -> Installation:
    """Build both distributions of this tree, unpack the source, and install it from there."""
    build = [sys.executable, "-m", "uv", "build", "-q", "--no-build-isolation", "--python", sys.executable]
    subprocess.run([*build, "-o", str(folder), str(ROOT)], check=True, timeout=300)
    (archive,) = folder.glob("*.tar.gz")
    subprocess.run(["tar", "-xf", str(archive), "-C", str(folder)], check=True)
    (wheel,) = folder.glob("*.whl")
    one = Installation(folder / archive.name.removesuffix(".tar.gz"), wheel, folder / "root")
    result = one.install()
    assert result.returncode == 0, result.stderr
    return one
