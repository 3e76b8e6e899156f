"""Thresholds of faults are times: the same at every rate of the loop and of the camera."""

import json
from dataclasses import astuple
from pathlib import Path

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.control.thresholds import Thresholds
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.renamed import RenamedKeyWarning
from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.cli.commands import tendond


@pytest.mark.parametrize(("period", "factor"), [(0.01, 1), (0.002, 5), (0.001, 10)])
def test_the_defaults_are_the_same_times_at_every_rate(period: float, factor: int) -> None:
    base = (20, 20, 5, 5, 10, 50, 20, 100, 20, 100, 100, 25, 50)
    config = parse_config(f"[loop]\nperiod = {period}\n", "t")
    assert astuple(Thresholds.from_config(config)) == tuple(factor * count for count in base)


def test_a_time_shorter_than_a_cycle_is_one_cycle() -> None:
    config = parse_config("[faults]\npose_timeout = 1e-4\n", "t")
    assert Thresholds.from_config(config).pose_timeout == 1


@pytest.mark.parametrize("frame", [0.01, 0.033])
def test_nothing_trips_at_1_khz_with_a_camera_of_100_or_30_hz(frame: float) -> None:
    text = f"[loop]\nperiod = 0.001\n[simulator]\nperiod = 0.001\n[simulator.mocap]\nperiod = {frame}\n"
    *_, last = closed_loop(parse_config(text, "t"), 2500, {100: ControlAction.ARM})
    assert (last.mode, last.reason) == (Mode.TRACKING, "armed by the operator")


@pytest.mark.parametrize("spacing", [1, 4, 10])
@pytest.mark.parametrize("kind", ["teleport", "bad poses"])
def test_bad_poses_are_a_fault_after_the_same_time_whatever_the_camera(spacing: int, kind: str) -> None:
    setup = CycleSetup.from_config(
        parse_config(
            "[faults]\npose_timeout = 5.0\nteleport_time = 0.2\ntip_speed_max = 0.5\n[commissioning]\nrest = false\n"
            "probe = false\n",
            "t",
        )
    )
    state = initial_state(setup)
    x, y, z = setup.rod.tip(state.rod).position.tolist()

    def pose(seq: int, shift: float) -> TipPose:
        return TipPose(seq=seq, stamp_ns=0, position=(x, y + shift, z), orientation=(1.0, 0.0, 0.0, 0.0))

    wrong, first = 0, 0
    for tick in range(200):
        good = tick < 12
        inputs = CycleInputs(request=ControlAction.ARM if tick == 5 else None)
        if tick % spacing == 0:
            sent = pose(tick + 1, 0.0) if good else pose(tick + 1, 0.3) if kind == "teleport" else pose(0, 0.0)
            inputs = inputs.model_copy(update={"pose": sent})
            if not good:
                wrong, first = wrong + 1, first or tick
        state, _, record = step(setup, state, inputs)
        if record.mode is Mode.FAULT:
            break
    assert record.reason.startswith(kind)
    assert 19 <= tick - first <= 19 + spacing
    assert wrong >= 2


def test_an_old_key_is_read_as_the_time_it_meant_with_one_warning() -> None:
    with pytest.warns(RenamedKeyWarning) as caught:
        config = parse_config(
            "[loop]\nperiod = 0.002\n[faults]\npose_stale = 40\n[limits]\nsustained = 500\n", "rig.toml"
        )
    assert (config.faults.pose_timeout, config.limits.limit_time) == (0.08, 1.0)
    assert str(caught[0].message) == (
        "rig.toml: faults.pose_stale = 40 (cycles) is read as faults.pose_timeout = 0.08 [s]: use that key"
    )
    assert len(caught) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "[faults]\npose_stale = 20\npose_timeout = 0.2\n",
            "rig.toml:2: faults.pose_stale: is now faults.pose_timeout",
        ),
        (
            "[faults]\nteleports = 'x'\n",
            "rig.toml:2: faults.teleports: was a number of cycles; give faults.teleport_time",
        ),
        ("[limits]\nsustained = 0.5\n", "rig.toml:2: limits.sustained: was a number of cycles; give limits.limit_time"),
    ],
)
def test_an_old_key_that_cannot_be_read_is_refused_with_the_new_one(text: str, said: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "rig.toml")
    assert str(caught.value).startswith(said)


def test_the_command_line_warns_of_an_old_key_in_a_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "rig.toml"
    path.write_text("[faults]\nmissed_ticks = 30\n")
    result = tendond(capsys, "config", "show", str(path), "--changed", "--json")
    assert json.loads(result.out) == {"faults": {"overrun_time": 0.3}}
    assert result.said.splitlines() == [
        f"tendond: warning: {path}: faults.missed_ticks = 30 (cycles) is read as faults.overrun_time = 0.3 [s]: "
        "use that key"
    ]


def test_config_check_notes_a_camera_slower_than_the_pose_timeout(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "rig.toml"
    path.write_text("[loop]\nperiod = 0.001\n[faults]\npose_timeout = 0.02\n[simulator.mocap]\nperiod = 0.033\n")
    notes = json.loads(tendond(capsys, "config", "check", str(path), "--json").out)["notes"]
    assert any("a pose each 33 ms" in note and "faults.pose_timeout = 20 ms" in note for note in notes)
    assert RigConfig().faults.pose_timeout == 0.2
