"""The rest before arming: a right rig is never refused, a wrong one always, and the mistake is named."""

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import RestWatch
from tendond.daemon.control.commissioning.mistakes import FRAMES, Signed
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.rest_grid import configured_rests
from tendond.daemon.control.commissioning.rotations import rotation_matrix, rotation_vectors, turn_by
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.commissioning.rest.rests import FAMILY, Array, as_quaternion, degrees, rest, unit
from tests.unit.control.cycles import START, go, pose

LOADS = [(1.0, 0.0), (0.8, 0.0), (1.2, 0.0), (1.0, 0.05), (0.8, 0.1), (1.2, 0.1)]
"""Young's modulus against the model's, weight on the tip [kg]."""


def watched(position: Array, rotation: Array, count: int = 10) -> RestWatch:
    watch = RestWatch()
    x, y, z = position.tolist()
    for _ in range(count):
        watch = watch.add((x, y, z), as_quaternion(rotation), 25)
    return watch


@pytest.mark.parametrize("extreme", [True, False])
def test_no_right_rig_is_refused(extreme: bool) -> None:
    """E +-20 %, up to 100 g, base 2 degrees and 2 mm off in any direction, noise of a tenth of a millimetre."""
    random = np.random.default_rng(7)
    for _ in range(200):
        part = 1.0 if extreme else random.uniform()
        stiffness = random.choice([0.8, 1.2]) if extreme else random.uniform(0.8, 1.2)
        weight = random.choice([0.0, 0.1]) if extreme else random.uniform(0.0, 0.1)
        tilt, offset = part * np.radians(2.0) * unit(random), part * 0.002 * unit(random)
        position, rotation = rest(stiffness, weight, tilt, offset)
        assert rest_objection(FAMILY, watched(position + 1e-4 * random.normal(size=3), rotation)) == ""


@pytest.mark.parametrize(("stiffness", "weight"), LOADS[::4])
@pytest.mark.parametrize("frame", FRAMES, ids=lambda frame: frame.name)
def test_every_wrong_frame_that_the_rest_can_show_is_refused_and_named(
    frame: Signed, stiffness: float, weight: float
) -> None:
    matrix, name = frame.matrix, frame.name
    if name == "with y mirrored":
        return  # the arm rests in y = 0: only the probe can tell
    position, rotation = rest(stiffness, weight)
    for turned in (matrix @ rotation @ matrix.T, rotation):  # a driver may or may not turn the orientation as well
        found = rest_objection(FAMILY, watched(matrix @ position, turned))
        assert found.startswith("the arm does not rest as the model does: ")
        mirrored = np.diag([1.0, -1.0, 1.0])
        same = {one.name for one in FRAMES if np.allclose(one.matrix, matrix @ mirrored)} | {name}
        named = found.split(" from the nearest rest; ")[1].split("; or: ")
        assert any(f"measured = model {one}" in named for one in same), named


@pytest.mark.parametrize(("stiffness", "weight"), LOADS)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_turned_or_displaced_base_is_refused(axis: int, stiffness: float, weight: float) -> None:
    position, rotation = rest(stiffness, weight)
    for angle in (10.0, -10.0):
        turn = turn_by(np.radians(angle) * np.eye(3)[axis])
        assert rest_objection(FAMILY, watched(turn @ position, turn @ rotation))
    for part in (0.04, -0.04, 0.1, -0.1):
        assert rest_objection(FAMILY, watched(position + part * FAMILY.length * np.eye(3)[axis], rotation))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p, r: (turn_by(degrees(x=10)) @ p, turn_by(degrees(x=10)) @ r), "rotated by 10 degrees about x"),
        (lambda p, r: (p + np.array([0.0, 0.05, 0.0]), r), "base +50 mm along y off"),
        (lambda p, r: (p + np.array([0.0, 0.0, 0.05]), r), "base +50 mm along z off"),
        (lambda p, r: (1000.0 * p, r), "measured = model in mm"),
        (lambda p, r: (0.9 * p, r), "lengths are 0.9 of the model's"),
        (lambda p, r: (0.01 * p, r), "lengths are 0.01 of the model's"),
        (lambda p, r: (p, rotation_matrix(np.roll(as_quaternion(r), -1))), "its quaternion in the order x y z w"),
        (lambda p, r: (np.array([0.0, 0.0, 0.5]), np.eye(3)), "the arm is straight"),
        (lambda p, r: (p, turn_by(degrees(z=30)) @ r), "only its orientation is off, rotated by 30 degrees about z"),
        (lambda p, r: (np.array([0.2, 0.1, 0.3]), r), "is it another robot's pose"),
    ],
)
def test_the_likeliest_mistake_is_named(change: object, words: str) -> None:
    assert callable(change)
    assert words in rest_objection(FAMILY, watched(*change(*rest())))


def test_a_moving_arm_has_to_wait() -> None:
    watch = RestWatch()
    for k in range(40):
        watch = watch.add((0.1 + 0.002 * k, 0.0, 0.45), (1.0, 0.0, 0.0, 0.0), 25)
    assert "the tip is moving" in rest_objection(FAMILY, watch)
    assert "wait until it rests" in rest_objection(FAMILY, watch)


def test_arming_is_refused_by_a_wrong_rest_and_granted_once_it_is_right() -> None:
    wrong = [CycleInputs(pose=pose(k, (0.0, -0.028, 0.499))) for k in range(10)]
    state, record = go(START, *wrong, CycleInputs(pose=pose(10, (0.0, -0.028, 0.499)), request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (False, Mode.IDLE)
    assert record.reply.startswith("not armed: the arm does not rest as the model does: tip at (0, -28, 499) mm")
    assert "x and y swapped" in record.reply
    state, _ = go(state, *[CycleInputs(pose=pose(11 + k)) for k in range(60)])
    _, record = go(state, CycleInputs(pose=pose(100), request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (True, Mode.PRETENSION)


def test_without_gravity_every_wrong_length_shows_and_no_swap_of_x_and_y() -> None:
    config = parse_config("[rod]\ngravity = [0.0, 0.0, 0.0]\n", "test")
    family = configured_rests(config, rod_from_section(config.rod, 0.01).parameters)
    assert family is not None
    straight = np.array([0.0, 0.0, 0.5])
    assert rest_objection(family, watched(straight, np.eye(3))) == ""
    assert "lengths are 0.9" in rest_objection(family, watched(0.9 * straight, np.eye(3)))
    assert rest_objection(family, watched(straight + np.array([0.02, 0.0, 0.0]), np.eye(3)))


def test_the_markers_axes_count_for_nothing_where_the_configuration_says_so() -> None:
    config = parse_config("[commissioning]\norientation = 3.2\n", "test")
    family = configured_rests(config, rod_from_section(config.rod, 0.01).parameters)
    assert family is not None
    position, rotation = rest()
    turned = watched(position, turn_by(degrees(z=90)) @ rotation)
    assert rest_objection(FAMILY, turned)
    assert rest_objection(family, turned) == ""


def test_rotation_vectors_come_back_up_to_half_a_turn() -> None:
    random = np.random.default_rng(3)
    for angle in (0.0, 1e-9, 1e-3, 1.0, 3.0, np.pi):
        vector = angle * unit(random)
        back = rotation_vectors(turn_by(vector))
        assert min(np.abs(back - vector).max(), np.abs(back + vector).max() if angle == np.pi else 9.0) < 1e-6
