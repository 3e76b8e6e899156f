"""Progress of what takes longer than a second: lines to a pipe, bars on a terminal, nothing beside JSON."""

import os
import pty
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tendond.offline import progress
from tendond.offline.progress import Lines, tracked, working
from tests.unit.cli.commands import tendond
from tests.unit.cli.test_unusable_files import FAULTS, NORMAL

SLOW = [
    ("log info {}", "reading normal.mcap"),
    ("log recover {} --out whole.mcap", "recovering normal.mcap"),
    ("log export {} --out run.csv", "exporting normal.mcap"),
    ("log compare {} {} --out compared", "comparing"),
    ("plot {} --out plots", "plotting normal.mcap"),
    ("log report {} --out run.html", "writing the report of normal.mcap"),
    ("replay {}", "replaying normal.mcap"),
    ("log what-if {} --law sliding_mode --out other.mcap", "running normal.mcap again"),
    ("config check", "setting up built-in configuration"),
    ("identify plan", "planning, and running the plan on the simulator"),
    ("doctor --no-servos", "checking: wake-up"),
    ("run --lockstep --cycles 1 --profile paper --log /proc/no.mcap", "setting up rig 'paper'"),
]
"""Commands that may take longer than a second, and the beginning of their lines."""

AS_JSON = ["log info {}", "log compare {} {} --out compared", "replay {}", "config check"]


@pytest.fixture(autouse=True)
def _impatient(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let every command be one that takes long."""
    stop = Lines.stop

    def stop_late(self: Lines) -> None:
        time.sleep(0.05)
        stop(self)

    monkeypatch.setattr(Lines, "stop", stop_late)
    monkeypatch.setattr(progress, "FIRST_SECONDS", 0.0)
    monkeypatch.setattr(progress, "PAUSE_SECONDS", 0.02)
    monkeypatch.delenv(progress.VARIABLE, raising=False)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("command", "what"), SLOW, ids=[command.split(" {}")[0] for command, _ in SLOW])
def test_a_command_that_takes_long_says_what_it_does(
    command: str, what: str, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, *(word.format(NORMAL) for word in command.split()))
    lines = [line for line in ended.said.splitlines() if what in line]
    assert lines, ended.said
    assert all(line.startswith("tendond: ") and line.endswith(" s") for line in lines), lines
    assert what not in ended.out


@pytest.mark.parametrize("command", AS_JSON)
def test_nothing_is_printed_beside_json(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, *(word.format(FAULTS) for word in command.split()), "--json")
    assert ended.said == ""
    assert ended.out.startswith("{")


def test_the_lines_count_and_come_ever_more_rarely(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "FIRST_SECONDS", 0.01)
    assert list(tracked(iter(range(40)), 40, "runs", quiet=True)) == list(range(40))
    assert capsys.readouterr().err == ""
    for _ in tracked(range(40), 40, "runs"):
        time.sleep(0.02)
    lines = capsys.readouterr().err.splitlines()
    assert 2 <= len(lines) < 10  # of 0.8 s: after 0.01, 0.03, 0.07, 0.15, 0.31, 0.63 s
    assert all(line.startswith("tendond: runs ") and " of 40, " in line for line in lines)


def test_nothing_is_printed_where_the_environment_says_so(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(progress.VARIABLE, "off")
    assert tendond(capsys, "log", "info", str(NORMAL)).said == ""


def test_work_is_silent_within_the_first_second(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "FIRST_SECONDS", 1.0)
    with working("reading") as work:
        work.update("the second part")
    assert capsys.readouterr().err == ""


def test_on_a_terminal_there_is_a_bar_on_standard_error_and_none_on_standard_output(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    code = (
        "import time\nfrom tendond.offline.progress import tracked\n"
        "for _ in tracked(range(4), 4, 'runs'): time.sleep(0.2)\nprint('done')"
    )
    environment = {**os.environ, "TERM": "xterm-256color"}
    found = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=slave, env=environment)
    os.close(slave)
    shown = os.read(master, 65536).decode()
    os.close(master)
    assert found.stdout == b"done\n"
    assert "runs" in shown
    assert "2/4" in shown
    assert "\x1b[" in shown
