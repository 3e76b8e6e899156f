"""Kernels have a writable folder, or a temporary one, or there is a message in one line."""

import os
import shutil
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

import tendond
from tendond.cli import kernel_folder
from tendond.cli.kernel_folder import is_writable, numbas_name, prepare

SOURCES = Path(tendond.__file__).parent.parent
NOBODY = 65534


def test_a_folder_that_can_be_written_to_or_made_is_distinguished_from_one_that_cannot(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert is_writable(tmp_path)
    assert is_writable(tmp_path / "not" / "yet")
    assert not is_writable(tmp_path / "file")
    assert not is_writable(tmp_path / "file" / "below")


@pytest.fixture
def nowhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make all of numba's folders read-only; temporary folders are below the one that is returned."""
    monkeypatch.setattr(kernel_folder, "is_writable", lambda folder: False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "given"))  # and back again afterwards
    return tmp_path


def test_nothing_is_changed_where_numba_finds_a_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    said: list[str] = []
    prepare(said.append)
    assert (os.environ["NUMBA_CACHE_DIR"], said) == (str(tmp_path), [])


def test_kernels_that_can_only_be_read_are_used_in_a_private_folder_that_is_said_once(nowhere: Path) -> None:
    given = nowhere / "given" / "model_abc"
    given.mkdir(parents=True)
    (given / "rod.march-1.py311.1.nbc").write_bytes(b"code")
    said: list[str] = []
    prepare(said.append)
    prepare(said.append)
    folder = nowhere / f"tendond-kernels-{os.getuid()}"
    assert os.environ["NUMBA_CACHE_DIR"] == str(folder)
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert (folder / "model_abc" / "rod.march-1.py311.1.nbc").read_bytes() == b"code"
    (line,) = said
    assert str(folder) in line
    assert "NUMBA_CACHE_DIR" in line


def test_a_folder_that_somebody_else_may_write_to_is_not_trusted(nowhere: Path) -> None:
    trap = nowhere / f"tendond-kernels-{os.getuid()}"
    trap.mkdir()
    trap.chmod(0o777)
    prepare(lambda line: None)
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    assert folder != trap
    assert folder.parent == nowhere
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


def test_numba_looks_where_kernels_are_put(tmp_path: Path) -> None:
    """numba's name for a folder of sources is undocumented, so it is read from numba."""
    from numba.core.caching import _CacheLocator

    assert _CacheLocator.get_suitable_cache_subpath(str(tmp_path / "rod.py")) == numbas_name(tmp_path)


@pytest.fixture
def installation() -> Iterator[Path]:
    """The sources as somebody else's, who is let in; below a folder that everybody may enter."""
    folder = Path(tempfile.mkdtemp(prefix="tendond-test-", dir="/tmp"))
    folder.chmod(0o755)
    (folder / "tmp").mkdir()
    (folder / "tmp").chmod(0o777)
    shutil.copytree(SOURCES / "tendond", folder / "tendond", symlinks=False)
    for one in (folder, *folder.rglob("*")):
        if one.name != "tmp" and not one.is_symlink():
            one.chmod(0o555 if one.is_dir() else 0o444)
    yield folder
    for one in (folder, *folder.rglob("*")):
        if one.is_dir() and one.stat().st_uid == os.getuid():
            one.chmod(0o755)
    shutil.rmtree(folder)


def as_another(installation: Path, *command: str, temporary: str) -> "subprocess.CompletedProcess[str]":
    """A command of a user who has no home and may write nowhere else than, perhaps, to a temporary folder."""
    root = ["setpriv", f"--reuid={NOBODY}", f"--regid={NOBODY}", "--clear-groups"] if os.getuid() == 0 else []
    environment = {
        "PATH": os.environ["PATH"], "HOME": "/nonexistent", "PYTHONPATH": str(installation), "TMPDIR": temporary,
        "PYTHONDONTWRITEBYTECODE": "1",
    }  # fmt: skip
    command = (*root, sys.executable, "-P", "-m", "tendond.cli", *command)
    return subprocess.run(command, env=environment, cwd="/", capture_output=True, text=True, timeout=300.0)


@pytest.mark.skipif(os.getuid() == 0 and not shutil.which("setpriv"), reason="no setpriv: apt install util-linux")
def test_a_user_without_a_home_uses_what_is_compiled_or_gets_a_line(installation: Path) -> None:
    version = as_another(installation, "--version", temporary=str(installation / "tmp"))
    if version.returncode:
        pytest.skip("this Python may not be run by another user")
    assert version.stderr == ""  # what needs no kernel says nothing of them
    found = as_another(installation, "config", "check", temporary=str(installation / "tmp"))
    assert found.returncode == 0, found.stderr
    assert ": OK; " in found.stdout
    assert "compiled kernels are kept in" in found.stderr
    assert "compiling" not in found.stderr
    doctor = as_another(installation, "doctor", "--no-servos", "--log", "/tmp", temporary=str(installation / "tmp"))
    assert "no other folder is writable" in doctor.stdout
    assert "Traceback" not in doctor.stderr
