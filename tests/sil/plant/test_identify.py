"""The excitation on a rig of real processes: recorded with its weight, and released when it is interrupted."""

import signal
import subprocess
from pathlib import Path

import pytest

from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.logs.log import load
from tendond.schemas.messages import Mode
from tests.sil.rig import Rig, rig

pytestmark = pytest.mark.sil

CONFIG = """
[rod]
tendon_stiffness = 20000.0
[limits]
displacement_min = -0.08
displacement_max = 0.08
displacement_rate = 0.085
[simulator]
drive = "displacement"
[simulator.rod]
tendon_stiffness = 20000.0
"""


def begin(one: Rig) -> "subprocess.Popen[str]":
    """`tendond identify run` of a short plan."""
    plan = ("--parts", "steps", "--reach", "0.6", "--weight", "0.03", "--yes")
    return one.start("identify", "run", "--log", str(one.folder / "run.mcap"), *plan)


def test_a_plan_is_carried_out_and_recorded_with_its_weight(tmp_path: Path) -> None:
    with rig(tmp_path, CONFIG) as one:
        simulator, operator = one.start("simulate"), begin(one)
        out, said = operator.communicate(timeout=120.0)
        assert operator.returncode == 0, said
        assert f"recorded: {tmp_path / 'run.mcap'}" in out
        one.end(simulator)
        again = one.command("identify", "run", "--log", str(tmp_path / "run.mcap"), "--yes")
        assert again.returncode == 2
        assert "exists: a log is never overwritten" in again.stderr
    found = load_recording(tmp_path / "run.mcap", {})
    assert found.weight == 0.03
    records = load(tmp_path / "run.mcap").records
    assert {Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING} <= {record.mode for record in records}
    assert records[-1].mode is Mode.IDLE
    assert not records[-1].command.armed


def test_ctrl_c_releases_the_tendons(tmp_path: Path) -> None:
    with rig(tmp_path, CONFIG) as one:
        simulator, operator = one.start("simulate"), begin(one)
        with one.session() as session:
            one.until(session, lambda status: status.mode is Mode.TRACKING)
        assert one.end(operator, signal.SIGINT)[0] == 130
        one.end(simulator)
    records = load(tmp_path / "run.mcap").records
    assert not records[-1].command.armed
    assert max(records[-1].command.tension) == 0.0


def test_a_simulator_with_an_ideal_drive_is_refused_before_the_arm_moves(tmp_path: Path) -> None:
    with rig(tmp_path, CONFIG.replace('drive = "displacement"', 'drive = "tension"')) as one:
        one.start("simulate")
        operator = begin(one)
        _, said = operator.communicate(timeout=120.0)
    assert operator.returncode == 2
    assert "tendond: rig 'sil' is a simulator with an ideal drive, which imposes the tensions" in said
    assert {record.mode for record in load(tmp_path / "run.mcap").records} <= {Mode.STARTING, Mode.IDLE}
