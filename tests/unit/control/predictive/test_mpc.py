"""The predictive law in the closed loop: it follows, keeps limits, says what it did, and is computed again."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.daemon.control.cycle import step
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.daemon.errors import LawError
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

POINT = {"kind": "point", "position": (0.1, 0.05, 0.482), "duration": 0.6}
CIRCLE = {"kind": "circle", "radius": 0.1, "period": 2.0, "duration": 0.6}


def rig(law: str = "mpc", **sections: Any) -> RigConfig:
    values: dict[str, Any] = {
        "control": {"law": law, "solver": "general"},
        "simulator": {"period": 0.01, "solver": "general"},
        "reference": POINT,
        "pretension": {"duration": 0.3},
    }
    return check_config(values | sections, "test")


def tracked(config: RigConfig, seconds: float, see: Any = None) -> list[Watched]:
    cycles = round((0.3 + seconds) / config.loop.period) + 12
    run = list(watched_loop(config, cycles, {10: ControlAction.ARM}, see_state=see))
    return [one for one in run if one.record.mode is Mode.TRACKING]


def errors(run: list[Watched]) -> np.ndarray:
    """Distances of the plant's tip from the reference [m]."""
    return np.array([np.linalg.norm(np.subtract(one.truth.position, one.record.reference.position)) for one in run])


def test_it_follows_a_moving_reference_without_lag() -> None:
    run = tracked(rig(reference=CIRCLE), 1.0)
    assert run[-1].record.mode is Mode.TRACKING
    assert errors(run)[60:].max() < 2e-4
    assert not any(one.record.limited for one in run[60:])


def test_a_weight_that_the_model_does_not_know_leaves_no_offset() -> None:
    run = tracked(rig(simulator={"period": 0.01, "solver": "general", "weight": {"mass": 0.005}}), 3.0)
    assert errors(run)[-20:].max() < 4e-4  # the observer's floor of noise


def test_its_terms_say_what_the_plan_is() -> None:
    record = tracked(rig(), 0.8)[-1].record
    assert record.terms["predicted"] == pytest.approx(record.reference.target, abs=1e-3)
    assert record.terms["shifted"] == record.terms["relaxed"] == 0.0
    assert record.terms["iterations"] != 0.0
    assert np.shape(record.law_state["tension"]) == (12 * 4,)


def test_a_spent_budget_applies_the_shifted_plan_and_says_so() -> None:
    config = rig(control={"law": "mpc", "solver": "general", "laws": {"mpc": {"budget": 1}}})
    run = tracked(config, 0.3)
    assert all(one.record.terms["shifted"] == 1.0 for one in run)
    assert np.ptp([one.record.command.tension for one in run], axis=0).max() < 1e-9


def test_a_jump_of_the_reference_is_planned_within_every_limit() -> None:
    jump = {"kind": "step", "across": 0.2, "branch": "below_135"}
    limits = {"tension_max": 20.0, "displacement_rate": 0.08, "tension_rate": 200.0}
    run = tracked(rig(reference=jump, limits=limits), 1.0)
    assert {name for one in run for name in one.record.limited} <= {"tension min"}
    drawn = np.array([one.record.command.displacement for one in run])
    assert np.abs(np.diff(drawn, axis=0)).max() > 0.9 * 0.08 * 0.01
    assert errors(run)[-10:].max() < 1e-3


def test_a_cycle_from_a_snapshot_is_the_same_to_the_last_bit() -> None:
    config = rig()
    states: list[CycleState] = []
    tracked(config, 0.2, states.append)
    fresh = CycleSetup.from_config(config)
    run = list(watched_loop(config, 50, {10: ControlAction.ARM}))
    before, inputs = states[45], run[45].record.inputs
    again = decode_state(CycleState, encode_state(before), fresh)
    _, _, record = step(fresh, again, inputs)
    assert record.terms == run[45].record.terms
    assert record.command == run[45].record.command


def test_two_sections_take_a_position_and_a_direction() -> None:
    pose = {"kind": "pose", "position": (0.1, 0.05, 0.37), "direction": (0.5, 0.2, 0.84), "moved_max": 0.01}
    arm = {"preset": "rao-2021"}
    config = rig(rod=arm, simulator={"period": 0.01, "rod": arm}, limits={"tension_max": 20.0}, reference=pose)
    run = tracked(config, 2.5)
    reference = CycleSetup.from_config(config).selection.reference
    assert isinstance(reference, PoseReference)
    w, x, y, z = run[-1].record.model.orientation
    direction = Rotation.from_quat((x, y, z, w)).as_matrix()[:, 2]
    assert errors(run)[-1] < 1e-3
    assert direction @ reference.pose(9.0).pose.direction > math.cos(math.radians(2.0))
    assert min(run[-1].record.command.tension) >= 1.0 - 1e-9


def test_the_shooting_rod_is_refused_in_one_line() -> None:
    with pytest.raises(
        LawError, match=r"control\.law = 'mpc' needs the general rod.*set control\.solver = \"general\""
    ):
        CycleSetup.from_config(rig(control={"law": "mpc", "solver": "shooting"}))


def test_without_a_solver_asked_for_the_model_is_the_general_rod() -> None:
    assert CycleSetup.from_config(rig(control={"law": "mpc"})).config.control.solver == "general"
