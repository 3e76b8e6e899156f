"""Teach-in on real Zenoh: a path is recorded from the bus while the arm moves, and played."""

import csv
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.sil.rig import rig

pytestmark = pytest.mark.sil

SLOW = """
[reference]
kind = "minimum_jerk"
across = 0.2
branch = "below_135"
duration = 4.0
"""


def test_a_path_is_recorded_from_the_bus_and_from_the_log_and_played_with_the_same_checks(tmp_path: Path) -> None:
    with rig(tmp_path, SLOW) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            one.until(session, lambda status: status.tip is not None)
            file = tmp_path / "path.csv"
            recorder = one.start("rig", "teach", "record", "--out", str(file))
            assert recorder.stderr is not None
            assert "recording: move the arm" in recorder.stderr.readline()
            one.arm(session)
            one.until(session, lambda status: status.tip is not None and abs(status.tip[0] - 0.2) < 2e-3)
            recorder.send_signal(signal.SIGINT)
            out, error = recorder.communicate(timeout=60.0)
            assert recorder.returncode == 130, error  # as after every Ctrl-C
            advised = shlex.split(out.split("play it on rig 'sil' while it is idle with: tendond ")[1])
            assert "would refuse" not in error
            with file.open() as stream:
                heading, *rows = list(csv.reader(stream))
            assert heading == ["time [s]", "x [m]", "z [m]"]
            assert float(rows[-1][1]) == pytest.approx(0.2, abs=0.01)
            assert one.ask(session, ControlAction.STOP).done
            one.until(session, lambda status: status.mode is Mode.IDLE)
            # Of an arm in motion, the tip may be beside where it can rest: the advice has what is needed then.
            assert one.command(*advised[: advised.index("--config")]).returncode == 0, advised
            moved = tmp_path / "moved.csv"
            moved.write_text("time [s],x [m],z [m]\n0,0.0,0.4\n1,0.0,0.6\n")
            refused = one.command("rig", "teach", "play", str(moved))
            assert refused.returncode != 0
            assert "mm from where the tip can rest; the nearest is" in refused.stderr
        one.end(one.started["simulate"])
        one.end(one.started["run"])
        again = tmp_path / "again.csv"
        command = [sys.executable, "-m", "tendond.cli", "log", "teach", str(tmp_path / "run.mcap")]
        said = subprocess.run([*command, "--out", str(again), "--columns", "position"], capture_output=True, text=True)
        early = subprocess.run([*command, "--from", "1000"], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert "would refuse to play it as it is: the law backstepping moves the tip in the bending plane" in said.stderr
    assert said.stdout.endswith("again.csv --config FILE\n")
    assert "has no pose from 1000 to inf s: it lasts" in early.stderr
    assert again.read_text().splitlines()[0] == "time [s],x [m],y [m],z [m]"
