"""Metadata of a log: the rig, and revision and versions of the code that wrote it."""

import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import llvmlite.binding

from tendond import __version__
from tendond.daemon.recording.run_files import FORMAT, LOG_FORMAT
from tendond.schemas.config.rig import RigConfig

LIBRARIES = ("numpy", "numba", "llvmlite", "pydantic", "eclipse-zenoh", "mcap")


def run_metadata(config: RigConfig) -> dict[str, str]:
    """Return the rig and the code of a log: revision and versions."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return {
        "rig": config.rig.name,
        "tendond": __version__,
        FORMAT: str(LOG_FORMAT),
        "revision": _revision(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cpu": llvmlite.binding.get_host_cpu_name(),  # compiled code, and so the last bit, is the processor's own
        **versions,
    }


def _revision() -> str:
    """Return the revision of the working copy, if it is one; no lock of its is taken, as `describe --dirty` would."""
    try:
        revision = _git("describe", "--always", "--abbrev=12")
        changes = _git("--no-optional-locks", "status", "--porcelain", "--untracked-files=no")
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return f"{revision}-dirty" if changes else revision


def _git(*arguments: str) -> str:
    folder = Path(__file__).resolve().parent
    result = subprocess.run(["git", *arguments], cwd=folder, capture_output=True, text=True, timeout=2.0, check=True)
    return result.stdout.strip()
