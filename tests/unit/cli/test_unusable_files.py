"""Files that a command cannot read or write are named in a line."""

from pathlib import Path

import pytest

from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import RUNNABLE, few_lines, tendond

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


REQUIRED = {
    "rig law": ["backstepping"],
    "rig reference": ["across=0.3"],
    "set": ["limits.tension_max=40"],
    "rig inject": ["noise"],
    "rig teach play": ["path.csv"],
    "servo setup": ["1"],
    "servo identify": ["0"],
    "servo reboot": ["1"],
    "simulate": ["--wired"],
}


LOG_COMMANDS = [
    *(("log", "info"), ("log", "recover"), ("log", "export"), ("replay",), ("log", "compare"), ("plot",), ("animate",)),
    *(("log", "report"), ("log", "view"), ("log", "what-if", "--closed-loop"), ("log", "tag"), ("log", "note")),
    ("log", "export", "--rosbag2"),
]


@pytest.mark.parametrize(
    "name", [name for name, one in RUNNABLE.items() if any(p.name == "config" for p in one.params)], ids=" ".join
)
@pytest.mark.parametrize("kind", ["missing", "folder", "unreadable", "no text", "no toml"])
def test_a_configuration_that_cannot_be_read_is_named(
    name: tuple[str, ...], kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = {"folder": tmp_path, "unreadable": Path("/proc/self/mem")}.get(kind, tmp_path / "rig.toml")
    if kind == "no text":
        path.write_bytes(b"\xff\xfe\x00")
    elif kind == "no toml":
        path.write_text("[rod\n")
    ended = tendond(capsys, *name, *REQUIRED.get(" ".join(name), []), "--config", str(path))
    assert ended.status == 2
    assert str(path) in ended.out + ended.said
    assert few_lines(ended.out + ended.said)


@pytest.mark.parametrize("name", LOG_COMMANDS, ids=" ".join)
@pytest.mark.parametrize("kind", ["missing", "folder", "unreadable", "no log", "empty"])
def test_a_log_that_cannot_be_read_is_named(
    name: tuple[str, ...], kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = {"folder": tmp_path, "unreadable": Path("/proc/self/mem")}.get(kind, tmp_path / "run.mcap")
    if kind in ("no log", "empty"):
        path.write_text("this is no log" if kind == "no log" else "")
    ended = tendond(capsys, *name, str(path))
    assert ended.status == 2
    assert str(path) in ended.said
    assert few_lines(ended.said)


@pytest.mark.parametrize(
    "command",
    [
        ("log", "export", str(NORMAL), "--out", "/proc/no/such.csv"),
        ("log", "recover", str(NORMAL), "--out", "/proc/no/such.mcap"),
        ("log", "report", str(NORMAL), "--out", "/proc/no/such.html"),
        ("plot", str(NORMAL), "--out", "/proc/no/such"),
        ("log", "compare", str(NORMAL), "--out", "/proc/no/such"),
        ("animate", str(NORMAL), "--out", "/proc/no/such.gif"),
        ("log", "what-if", str(NORMAL), "--law", "sliding_mode", "--out", "/proc/no/such.mcap"),
        ("demo", "--out", "/proc/no"),
        ("try", "--out", "/proc/no"),
        ("config", "new", "/proc/no/rig.toml", "--yes"),
        ("run", "--log", "/proc/no/such.mcap", "--lockstep", "--cycles", "1"),
    ],
    ids=lambda command: " ".join(command[:2]),
)
def test_a_place_that_cannot_be_written_is_named(command: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, *command)
    assert ended.status in (1, 2)
    assert "/proc/no" in ended.said
    assert few_lines(ended.said)


def test_a_machine_with_no_folder_for_kernels_at_all_gets_a_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def imports_a_kernel(*_: object, **__: object) -> None:
        raise RuntimeError("cannot cache function 'march': no locator available for file '/usr/lib/march.py'")

    monkeypatch.setattr("tendond.cli.config.check.run_check", imports_a_kernel)
    found = tendond(capsys, "config", "check")
    assert found.status == 1
    assert found.said == ("tendond: no writable folder for compiled kernels: set NUMBA_CACHE_DIR to one\n")
