"""The general rod behind the shooting rod's interface: the same rests, exact derivatives, states that can be copied."""

import copy
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.daemon.control.snapshot import from_plain, to_plain
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.state import RodState
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.interface import ModelState
from tendond.model.rods.selection import Solver, model_rod, rod_from_section, solver_of
from tendond.model.strain import StrainRod
from tendond.schemas.config.rig import RigConfig, check_config

Array = NDArray[np.float64]
PRESETS = ["paper", "nitinol", "rao-2021"]


@cache
def general(preset: str) -> GeneralRod:
    return GeneralRod(StrainRod.from_config(preset).robot, 0.01)


def pull(rod: GeneralRod, bend: float = 1.0) -> Array:
    """Tensions that bend the robot, the first tendon and a little of the second."""
    tensions = np.zeros(rod.parameters.tendon_count)
    tensions[0] = bend * rod.parameters.bending_stiffness / rod.parameters.length / 0.01
    tensions[1] = 0.2 * tensions[0]
    return tensions


def moving(rod: GeneralRod) -> GeneralState:
    state = rod.solve_static(pull(rod))
    for _ in range(3):
        state = rod.step(state, pull(rod, 0.6), tip_force=(0.0, 1e-3, 0.0))
    return state


@pytest.mark.parametrize("preset", PRESETS)
def test_acceleration_and_gain_are_those_of_the_coming_step(preset: str) -> None:
    rod = general(preset)
    state, h = moving(rod), rod.time_step
    tip = rod.tip(state)
    after = rod.step(state, state.tensions, tip_force=state.tip_force)
    np.testing.assert_allclose(tip.acceleration, (after.velocity - state.velocity) / h, rtol=1e-9, atol=1e-9)
    size = float(np.abs(tip.input_gain).max())
    for tendon in range(rod.parameters.tendon_count):
        change = np.zeros(rod.parameters.tendon_count)
        change[tendon] = 1e-4 * (1.0 + state.tensions[0])
        ends = [rod.step(state, np.abs(state.tensions + sign * change), tip_force=state.tip_force) for sign in (1, 0)]
        slope = (ends[0].velocity - ends[1].velocity) / change[tendon] / h
        np.testing.assert_allclose(tip.input_gain[:, tendon], slope, atol=2e-3 * size)
        np.testing.assert_allclose(rod.velocity_jacobian(state, tendon), h * tip.input_gain[:, tendon], rtol=1e-9)
    np.testing.assert_allclose(tip.drift + tip.input_gain @ state.tensions, tip.acceleration)
    assert tip.velocity.tolist() == state.velocity.tolist()


@pytest.mark.parametrize("preset", PRESETS)
def test_a_prediction_is_the_step_and_its_jacobian_the_steps(preset: str) -> None:
    rod = general(preset)
    state, n = moving(rod), rod.parameters.tendon_count
    inputs = np.abs(np.random.default_rng(0).normal(size=(2, n)))
    force = np.array([0.0, 2e-3, 0.0])
    found = rod.predict(state, pull(rod), inputs, force)
    after = rod.step(state, pull(rod), tip_force=force)
    np.testing.assert_allclose(found.position, after.position, atol=1e-12)
    np.testing.assert_allclose(found.velocity, after.velocity, atol=1e-9)
    np.testing.assert_allclose(found.direction, rod.tip(after).rotation[:, 2], atol=1e-12)
    step = 1e-4
    for column in range(2):
        moved = rod.step(state, pull(rod) + step * inputs[column], tip_force=force)
        slope = (moved.position - after.position) / step
        np.testing.assert_allclose(found.position_jacobian[:, column], slope, atol=1e-3 * np.abs(slope).max())
        slope = (rod.tip(moved).rotation[:, 2] - rod.tip(after).rotation[:, 2]) / step
        np.testing.assert_allclose(found.direction_jacobian[:, column], slope, atol=1e-3 * np.abs(slope).max())


def test_the_papers_robot_rests_as_the_shooting_rod_does() -> None:
    section = RigConfig().rod
    ours, shooting = general("paper"), rod_from_section(section, 0.01)
    own = theirs = None
    for tension in (5.0, 20.0, 43.0):
        tensions = [tension, 0.0, 0.0, 0.0]
        own, theirs = ours.solve_static(tensions, start=own), shooting.solve_static(tensions, start=theirs)
        there = shooting.tip(theirs)
        np.testing.assert_allclose(own.position, there.position, atol=1e-4 * section.length)
        np.testing.assert_allclose(ours.tip(own).rotation, there.rotation, atol=1e-3)
        for elastic in (False, True):
            ends = shooting.displacements(theirs, elastic=elastic)
            np.testing.assert_allclose(ours.displacements(own, elastic=elastic), ends, atol=2e-5)
        np.testing.assert_allclose(ours.curve(own, 20), shooting.curve(theirs, 20), atol=2e-4)
        for one, other in zip(ours.tendon_paths(own), shooting.tendon_paths(theirs), strict=True):
            np.testing.assert_allclose(one[[0, -1]], other[[0, -1]], atol=1e-3)


@pytest.mark.parametrize("preset", PRESETS)
def test_a_state_from_its_text_steps_to_the_last_bit_as_the_one_in_memory(preset: str) -> None:
    rod = general(preset)
    state = moving(rod)
    text = to_plain(state)
    again = from_plain(ModelState, text, None)
    assert isinstance(again, GeneralState)
    other = GeneralRod(rod.robot, 0.01)
    ours, theirs = rod.step(state, pull(rod)), other.step(again, pull(rod))
    for _ in range(5):
        ours, theirs = rod.step(ours, pull(rod, 0.8)), other.step(copy.deepcopy(theirs), pull(rod, 0.8))
        rod.curve(ours), rod.tendon_paths(ours), rod.node_positions(ours), rod.displacements(ours)
        assert ours.strain.strain.tobytes() == theirs.strain.strain.tobytes()
        assert rod.tip(ours).input_gain.tobytes() == other.tip(theirs).input_gain.tobytes()
    shooting = rod_from_section(RigConfig().rod, 0.01).solve_static()
    assert isinstance(from_plain(ModelState, to_plain(shooting), None), RodState)


@pytest.mark.parametrize(
    ("rod", "wanted", "solver"),
    [
        ({}, None, "shooting"),
        ({}, "general", "general"),
        ({"preset": "nitinol"}, None, "general"),  # 2 % of damping
        ({"preset": "nitinol"}, "shooting", "shooting"),
        ({"preset": "nitinol", "damping_ratio": 0.08}, None, "shooting"),
        ({"preset": "rao-2021"}, None, "general"),
        ({"preset": "rao-2021", "damping_ratio": 0.5}, None, "general"),
    ],
)
def test_the_shooting_rod_is_chosen_where_it_describes_a_robot_that_is_damped(
    rod: dict[str, object], wanted: Solver | None, solver: Solver
) -> None:
    config = check_config({"rod": rod, "control": {"solver": wanted}}, "test")
    assert solver_of(config.rod, config.control.solver) == solver
    assert isinstance(model_rod(config), GeneralRod) is (solver == "general")


def test_sections_are_refused_by_the_shooting_rod_by_their_key() -> None:
    config = check_config({"rod": {"preset": "rao-2021"}, "control": {"solver": "shooting"}}, "test")
    with pytest.raises(ParameterError, match=r"^rod\.section: 2 sections: the shooting rod is one straight"):
        model_rod(config)


def test_a_robot_of_twice_the_compliance_yields_twice() -> None:
    robot = general("nitinol").robot
    small = (1e-3, 0.0, 0.0)
    once, twice = (GeneralRod(robot, 0.01, factor) for factor in (1.0, 2.0))
    moved = [rod.solve_static(tip_force=small).position[0] for rod in (once, twice)]
    assert moved[1] == pytest.approx(2.0 * moved[0], rel=1e-3)
    assert twice.arm_stiffness == pytest.approx(0.5 * once.arm_stiffness)
    assert twice.parameters.bending_stiffness == pytest.approx(0.5 * once.parameters.bending_stiffness)


def test_loads_that_are_none_are_refused() -> None:
    rod = general("nitinol")
    for tensions in ([1.0], [-1.0, 0.0, 0.0], [float("nan"), 0.0, 0.0]):
        with pytest.raises(ParameterError, match="tensions must be 3 finite numbers"):
            rod.step(rod.solve_static(), tensions)
    with pytest.raises(ParameterError, match="tip_force"):
        rod.solve_static(tip_force=(float("inf"), 0.0, 0.0))


def test_a_tip_whose_coming_step_has_no_solution_has_no_gain(monkeypatch: pytest.MonkeyPatch) -> None:
    rod = GeneralRod(general("nitinol").robot, 0.01)
    state = moving(rod)
    known = rod.tip(state)

    def fail(*arguments: object) -> None:
        raise ConvergenceError("none", 0.0, 0.0, 0)

    monkeypatch.setattr(rod, "_ahead", fail)
    found = rod.tip(state)
    assert not found.input_gain.any()
    assert not found.acceleration.any()
    assert (found.position.tolist(), found.rotation.tolist()) == (known.position.tolist(), known.rotation.tolist())


def test_a_rod_whose_tendons_rub_steps_and_predicts_in_tension_drive_and_its_state_is_data() -> None:
    robot = StrainRod.from_config("paper").robot
    rod = GeneralRod(replace(robot, tendons=tuple(replace(one, friction=0.2) for one in robot.tendons)), 0.01)
    loose = general("paper")
    state, free = rod.solve_static([20.0, 1.0, 1.0, 1.0]), loose.solve_static([20.0, 1.0, 1.0, 1.0])
    assert state.position[0] < free.position[0]
    ends = rod.end_tensions(state)
    assert ends[0] < 0.9 * 20.0
    assert ends[2] > 1.05 * 1.0
    stretch = rod.displacements(state, elastic=True) - rod.displacements(state)
    assert ends[0] < stretch[0] * rod.tendon_stiffness[0] < 20.0
    tensions = np.array([22.0, 1.0, 1.0, 1.0])
    found = rod.predict(state, tensions, np.eye(4)[:2], np.zeros(3))
    after = rod.step(state, tensions)
    np.testing.assert_allclose(found.position, after.position, atol=1e-9)
    assert rod.tip(after).input_gain[0, 0] != 0.0
    again = from_plain(GeneralState, to_plain(after), None)
    np.testing.assert_array_equal(rod.step(again, tensions).position, rod.step(after, tensions).position)


def test_a_robot_whose_tendons_rub_is_run_as_the_general_rod() -> None:
    config = check_config({"rod": {"tendon_friction": 0.1}}, "rig.toml")
    assert solver_of(config.rod, None) == "general"
    assert solver_of(config.rod, "shooting") == "shooting"
