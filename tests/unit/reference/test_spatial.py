"""References in space: where the tip can rest, trajectories there, their time; and the law that follows them."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import sensitivity
from tendond.daemon.control.reference.spatial import SpatialReference
from tendond.daemon.control.reference.workspace import Surface
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.errors import LawError, TargetError
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.model.tendons.allocation import Allocation
from tendond.offline.trials.measure import run_trial
from tendond.offline.trials.paths import Trial
from tendond.schemas.config.presets import WIRED_SPACE
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.rod.rods import Array

BASE = RigConfig()
ROD = rod_from_section(BASE.rod, BASE.loop.period)
SURFACE = Surface(ROD, Allocation(BASE.rod.tendon_positions, BASE.pretension.tension_min, BASE.limits.tension_max))


def config(reference: dict[str, Any], **sections: dict[str, Any]) -> RigConfig:
    return check_config({"control": {"law": "sensitivity"}, "reference": reference, **sections}, "test")


def spatial(reference: dict[str, Any], **sections: dict[str, Any]) -> SpatialReference:
    found = CycleSetup.from_config(config(reference, **sections)).selection.reference
    assert isinstance(found, SpatialReference)
    return found


def rest(moment: Array) -> Array:
    """Tip of the rod at rest under the tensions for a bending moment [m]."""
    return ROD.tip(ROD.solve_static(SURFACE.allocation.tensions(moment))).position


@pytest.mark.parametrize("wanted", [(0.25, 0.0), (-0.1, 0.2), (0.0, -0.3), (0.0, 0.0)])
def test_a_place_over_x_and_y_is_found_and_a_fresh_static_solution_agrees(wanted: tuple[float, float]) -> None:
    found, missing = SURFACE.find(np.array(wanted), "position")
    assert np.linalg.norm(missing) < 1e-6
    assert rest(found.moment)[:2] == pytest.approx(wanted, abs=1e-6)


def test_one_x_and_y_has_two_shapes() -> None:
    at_106 = SURFACE.find(np.array([0.34, 0.0]), "position")[0]
    at_165 = SURFACE.find(np.array([0.34, 0.0]), "position", above_135=True)[0]
    assert at_106.place[2] == pytest.approx(0.266, abs=2e-3)
    assert at_165.place[2] == pytest.approx(0.0475, abs=2e-3)


def test_a_direction_is_found() -> None:
    wanted = np.array([0.5, -0.6, math.sqrt(1.0 - 0.61)])
    found, missing = SURFACE.find(wanted, "direction")
    assert np.linalg.norm(missing) < 1e-5
    assert found.place[3:] == pytest.approx(wanted, abs=1e-5)


def test_what_cannot_be_reached_gets_the_nearest_that_can() -> None:
    """The nearest point of the surface: what is missing is normal to the directions in which the tip can move."""
    found, missing = SURFACE.find(np.array([0.25, 0.1, 0.42]), "position")
    assert 1e-3 < np.linalg.norm(missing) < 0.1
    jacobian = found.jacobian[:3] / np.linalg.norm(found.jacobian[:3], axis=0)
    assert jacobian.T @ missing == pytest.approx(np.zeros(2), abs=1e-4)


def test_a_reference_is_moved_to_where_the_tip_can_rest_and_says_by_how_many_metres() -> None:
    moved = spatial({"kind": "point", "position": (0.25, 0.1, 0.38)})
    assert 1e-3 < moved.moved < 2e-3
    assert moved.notes == (f"the trajectory was moved by up to {moved.moved:.4f} m, to where the tip can rest",)
    with pytest.raises(TargetError, match=r"leads to \(-0\.5000, 0\.0000\), 0\.1\d+ m from where .*moved_max = 0\.02"):
        spatial({"kind": "line", "start": (-0.5, 0.0), "end": (0.2, 0.0)})


@pytest.mark.parametrize("kind", ["line", "circle", "helix", "figure_eight"])
def test_a_reference_begins_and_ends_at_rest_and_its_derivatives_are_those_of_its_position(kind: str) -> None:
    one = spatial({"kind": kind, "laps": 1})
    h = 1e-4
    for time in np.linspace(0.05, one.arrival - 0.05, 23):
        before, now, after = (np.array(one.at(t).position) for t in (time - h, time, time + h))
        assert one.at(time).velocity == pytest.approx((after - before) / (2.0 * h), abs=1e-4)
        assert one.at(time).acceleration == pytest.approx((after - 2.0 * now + before) / h**2, abs=2e-2)
    for time in (0.0, one.arrival, one.arrival + 5.0):
        assert one.at(time).velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert one.at(one.arrival).position == pytest.approx(one.target, abs=1e-9)
    assert one.notes == ()


def test_servos_that_are_slow_slow_the_reference_down_and_it_says_so() -> None:
    quick = spatial({"kind": "circle"})
    slow = spatial({"kind": "circle"}, limits={"displacement_rate": 0.02})
    assert slow.arrival > 1.5 * quick.arrival
    assert any("times as long as asked for, because of limits.displacement_rate" in note for note in slow.notes)
    stretch, timing = slow.stretches[1]
    rates = [
        np.abs(stretch.at(place)[1][stretch.DISPLACEMENT] * speed).max()
        for place, speed, _ in map(timing.progress, np.linspace(0.0, timing.end, 500))
    ]
    assert 0.015 < max(rates) <= 0.02


def test_the_wired_preset_is_slowed_and_a_csv_of_four_columns_is_a_reference() -> None:
    assert check_config({"reference": {"kind": "circle"}, "control": {"law": "sensitivity"}}, "test").reference.in_space
    assert 'law = "sensitivity"' in WIRED_SPACE
    samples = [(0.0, 0.1, 0.0, 0.485), (1.0, 0.1, 0.1, 0.475), (2.0, 0.0, 0.1, 0.486)]
    one = spatial({"kind": "samples", "samples": samples})
    assert one.at(one.approach_time + 1.0).position == pytest.approx((0.1, 0.1, 0.475), abs=5e-3)
    with pytest.raises(ConfigError, match="all have three numbers, or all four"):
        config({"kind": "samples", "samples": [(0.0, 0.1, 0.4), (1.0, 0.1, 0.0, 0.4)]})


def test_planar_laws_refuse_a_reference_in_space_and_few_tendons_refuse_the_law() -> None:
    with pytest.raises(LawError, match=r"backstepping moves the tip in the bending plane.* select the law sensitivity"):
        CycleSetup.from_config(check_config({"reference": {"kind": "circle"}}, "test"))
    line = {"tendon_positions": [(0.02, 0.0), (0.015, 0.0), (-0.02, 0.0), (-0.015, 0.0)]}  # on a line, as two are
    with pytest.raises(LawError, match="sensitivity bends the rod to every side: the tendons do not surround"):
        CycleSetup.from_config(config({}, rod=line, simulator={"rod": line}))


@pytest.mark.parametrize("unlike", [False, True])
def test_a_circle_is_followed_within_the_goal(unlike: bool) -> None:
    trial = Trial("circle", {"kind": "circle", "radius": 0.32, "period": 2.0, "laps": 1}, unlike)
    outcome = run_trial(BASE, trial)
    assert outcome.meets, (outcome.rms_mm, outcome.reason)
    assert outcome.min_tension_n >= BASE.pretension.tension_min - 1e-9
    assert outcome.limited == 0


def test_the_straight_rod_is_passed_without_a_jump() -> None:
    """A line through the middle: tendons hand over there, and the paper's b_c would vanish."""
    outcome = run_trial(BASE, Trial("line", {"kind": "line", "period": 3.0, "laps": 1}))
    assert outcome.rms_mm < 1.0
    assert outcome.largest_change_n < 1.0


def test_a_direction_is_followed() -> None:
    wanted = np.array([0.4, 0.5, 0.7])
    wanted /= np.linalg.norm(wanted)
    trace = list(
        watched_loop(config({"kind": "point", "direction": tuple(wanted.tolist())}), 200, {5: ControlAction.ARM})
    )
    assert trace[-1].record.mode is Mode.TRACKING
    w, x, y, z = trace[-1].record.model.orientation
    direction = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
    assert direction == pytest.approx(wanted, abs=1e-3)


def test_the_law_asks_for_nothing_when_nothing_is_missing_and_knows_its_parameters() -> None:
    parameters = sensitivity.Parameters()
    assert (parameters.rate, parameters.smoothing) == (30.0, 100.0)
    trace = list(watched_loop(config({"kind": "point", "position": (0.2, 0.1, 0.43)}), 260, {5: ControlAction.ARM}))
    tensions = np.array([watched.record.command.tension for watched in trace[-20:]])
    assert np.ptp(tensions, axis=0) == pytest.approx(np.zeros(4), abs=1e-3)


def run_with_fault(one: RigConfig, servo: int | None, cycles: int) -> Iterator[CycleRecord]:
    """The closed loop, with a tendon cut in the middle."""
    setup = CycleSetup.from_config(one)
    state, plant = initial_state(setup), Plant(one, rod_from_section(one.simulator.rod, one.loop.period))
    for tick in range(cycles):
        pose, tendons, _ = plant.observe(tick)
        if servo is not None and tick == cycles // 2:
            assert plant.faults.cause(FaultRequest(fault=Fault.CUT, servo=servo)).done
        request = ControlAction.ARM if tick == 5 else None
        state, command, record = step(setup, state, CycleInputs(pose=pose, tendon_state=tendons, request=request))
        yield record
        plant.step(command)


@pytest.mark.parametrize("drive", ["tension", "displacement"])
def test_a_tendon_that_is_cut_is_named_and_the_arm_released(drive: str) -> None:
    simulator: dict[str, Any] = {"drive": drive}
    sections: dict[str, Any] = {"simulator": simulator}
    if drive == "displacement":
        sections |= {"rod": {"tendon_stiffness": 2e4}, "limits": {"slack": 0.001}}
        simulator["rod"] = {"tendon_stiffness": 2e4}
    one = config({"kind": "circle", "period": 2.0}, **sections)
    records = list(run_with_fault(one, 2, 500))
    fault = next(record for record in records if record.mode is Mode.FAULT)
    assert fault.reason.startswith("tendon 1 slack: 0.0 N reported where the model has")
    released = [np.array(record.command.tension) for record in records if record.mode is Mode.FAULT]
    assert np.all(np.diff(np.array(released), axis=0) <= 1e-9)
    assert records[-1].command.tension == (0.0,) * 4
    assert all(record.mode is not Mode.FAULT for record in run_with_fault(one, None, 300))
