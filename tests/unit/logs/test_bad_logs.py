"""A bad log is one line and exit status 2 for every function and command that reads it."""

from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.writer import Writer

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.offline.logs import load
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import load as load_log
from tests.golden.scripts import FOLDER
from tests.unit.logs.commands import damaged, run_command
from tests.unit.logs.logs import rewritten

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


def something_else(path: Path) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()


def future(path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        return data.replace(b'{"version":2,', b'{"version":99,', 1) if topic == CYCLE.topic else data

    rewritten(NORMAL, path, change)


def future_state(path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        return data.replace(b'{"version":2,', b'{"version":99,', 1) if topic == STATE.topic else data

    rewritten(NORMAL, path, change)


BAD: dict[str, tuple[Callable[[Path], object], str]] = {
    "no-mcap": (lambda path: path.write_bytes(b"time,x\n0,1\n" * 9), "is not an MCAP file"),
    "empty": (lambda path: path.write_bytes(b""), "is not an MCAP file"),
    "else": (something_else, "is an MCAP file, but not a log of tendond"),
    "no-cycles": (lambda path: rewritten(NORMAL, path, lambda topic, data: None), "contains no cycles"),
    "no-attachment": (lambda path: rewritten(NORMAL, path, attach=False), "has no configuration ('rig.json')"),
    "damaged": (lambda path: damaged(NORMAL, path), "'tendond log recover"),
    "future": (future, "read the log with the version of tendond that wrote it"),
    "future-state": (future_state, "message on 'state': version = 99"),
    "future-configuration": (
        lambda path: rewritten(NORMAL, path, config='{"rig": {"colour": "red"}}'),
        "rig.json: rig.colour: unknown key",
    ),
    "future-calibration": (
        lambda path: rewritten(NORMAL, path, calibration='{"version": 99}'),
        "calibration.json: version = 99",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_log_is_one_line_for_whatever_reads_it(tmp_path: Path, name: str) -> None:
    from tendond.offline.replay.rerun import rerun

    make, message = BAD[name]
    path = tmp_path / "a.mcap"
    make(path)
    for read in (rerun,) if name == "future-state" else (load, load_log, rerun):
        with pytest.raises(LogError) as caught:
            read(path)
        assert message in str(caught.value), read
        assert "\n" not in str(caught.value)
        assert isinstance(caught.value, UsageError)  # exit status 2


COMMANDS = {
    "replay": ("replay",),
    "variant": ("log", "what-if", "--law", "sliding_mode"),
    "closed-loop": ("log", "what-if", "--closed-loop"),
    "info": ("log", "info"),
    "recover": ("log", "recover"),
    "export": ("log", "export"),
    "smooth": ("log", "smooth"),
    "compare": ("log", "compare"),
    "plot": ("plot",),
    "animate": ("animate",),
    "report": ("log", "report"),
    "view": ("log", "view"),
}


WORKS = {  # health is what `log info` is for, and repair what `log recover` is for
    *(("info", "damaged"), ("recover", "damaged"), ("recover", "no-attachment"), ("recover", "future")),
    *(("recover", "future-configuration"), ("recover", "future-calibration"), ("recover", "future-state")),
    *(("view", "damaged"), ("view", "future"), ("view", "future-state")),  # serves until then
    *((command, "future-state") for command in ("info", "export", "smooth", "compare", "plot", "animate", "report")),
    *((command, "future-state") for command in ("variant", "closed-loop")),
}


@pytest.mark.parametrize("name", BAD)
def test_every_command_refuses_a_bad_log_in_one_line_with_exit_status_2(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mcap"
    make, message = BAD[name]
    make(path)
    for command, arguments in COMMANDS.items():
        if (command, name) in WORKS:
            continue
        result = run_command(*arguments, str(path))
        assert result.returncode == 2, (command, result)
        assert result.stderr.count("\n") == 1, (command, result)
        assert result.stderr.startswith(f"tendond: {path}: "), (command, result)
        nothing = command == "recover" and name in ("else", "no-cycles")
        assert ("nothing in it is whole" if nothing else message) in result.stderr, (command, result)
        assert {file.name for file in tmp_path.iterdir()} == {"a.mcap"}, command


@pytest.mark.parametrize("name", ["damaged", "future-state"])
def test_what_a_command_does_not_need_may_be_bad(tmp_path: Path, name: str) -> None:
    make, _ = BAD[name]
    make(tmp_path / "a.mcap")
    for command in ("info", "recover"):
        result = run_command(*COMMANDS[command], str(tmp_path / "a.mcap"))
        assert (result.returncode, result.stderr) == (0, ""), (command, result)
