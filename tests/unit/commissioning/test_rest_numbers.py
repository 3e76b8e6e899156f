"""The family of rests and the fit to it, number by number: rotations, misfits in closed form, the grid, the words."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.averages import RESTLESS, RestWatch
from tendond.daemon.control.commissioning.mistakes import _frames, likely_mistakes
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.rest_grid import configured_rests, largest_weight, rest_family
from tendond.daemon.control.commissioning.rests import Fit, RestFamily, Tolerances
from tendond.daemon.control.commissioning.rotations import rotation_matrix, rotation_vectors, turn_by
from tendond.daemon.control.setup import rod_from_section
from tendond.model.errors import ConvergenceError
from tendond.model.rod.rod import Rod
from tendond.schemas.config.rig import parse_config
from tests.unit.commissioning.rests import FAMILY, as_quaternion, degrees, rest

Array = NDArray[np.float64]
TILT, OFFSET, MARKERS = 0.03, 0.004, 0.2
LENGTH = 0.5
NONE = np.zeros(3)


def family(*positions: tuple[float, float, float]) -> RestFamily:
    """Rests of upright tips, each with a weight and a stiffness of its own."""
    places = np.array(positions or ((0.0, 0.0, LENGTH),))
    count = len(places)
    index = np.arange(count, dtype=np.float64)
    return RestFamily(
        LENGTH, Tolerances(TILT, OFFSET, MARKERS), 0.01 * index, 1.0 + index, places,
        np.tile(np.eye(3), (count, 1, 1)),
    )  # fmt: skip


UP = np.array([0.0, 0.0, LENGTH])


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_quarter_turn_takes_each_axis_to_the_next(axis: int) -> None:
    turn = turn_by(0.5 * math.pi * np.eye(3)[axis])
    first, second = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
    assert turn @ np.eye(3)[axis] == pytest.approx(np.eye(3)[axis])
    assert turn @ first == pytest.approx(second)
    assert turn @ second == pytest.approx(-first)
    q = [math.sqrt(0.5), 0.0, 0.0, 0.0]
    q[axis + 1] = math.sqrt(0.5)
    assert rotation_matrix(tuple(3.0 * x for x in q)) == pytest.approx(turn)  # of any size


def test_a_turn_about_any_axis_is_rodrigues_formula_and_comes_back_as_its_vector() -> None:
    random = np.random.default_rng(1)
    for angle in (1e-9, 1e-4, 0.7, 2.0, 3.1, math.pi):
        axis = random.normal(size=3)
        axis /= np.linalg.norm(axis)
        x, y, z = axis
        cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        matrix = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
        assert turn_by(angle * axis) == pytest.approx(matrix)
        back = rotation_vectors(np.stack([matrix, np.eye(3)]))
        sign = math.copysign(1.0, float(back[0] @ axis)) if angle == math.pi else 1.0
        assert back[0] == pytest.approx(sign * angle * axis, abs=1e-7)
        assert back[1] == pytest.approx(NONE)
    assert turn_by(NONE) == pytest.approx(np.eye(3))
    for axis in np.eye(3):
        assert np.abs(rotation_vectors(turn_by(math.pi * axis))) == pytest.approx(math.pi * axis)


def test_a_rest_may_fit_within_twice_what_is_tolerated() -> None:
    limit = 2.0 * math.sqrt(2.0) * (TILT * LENGTH + OFFSET)
    two = family((0.0, 0.0, LENGTH), (1.0, 0.0, 0.0))
    for position in (UP, np.array([1.0, 0.0, 0.0])):
        assert two.may_fit(position + np.array([0.0, 0.999 * limit, 0.0]))
        assert not two.may_fit(position + np.array([0.0, 1.001 * limit, 0.0]))


def test_the_misfit_is_that_of_the_likeliest_tilt_markers_and_offset() -> None:
    """Along the rod an offset only; about it a turn of base or markers; across it all three: in closed form."""
    one = family()
    exact = one.fit(UP, np.eye(3))
    assert exact.misfit == pytest.approx(0.0)
    assert exact.is_tolerated
    along = one.fit(UP + np.array([0.0, 0.0, 0.006]), np.eye(3))
    assert along.misfit == pytest.approx((0.006 / OFFSET) ** 2)
    assert along.offset == pytest.approx([0.0, 0.0, 0.006])
    assert along.tilt == pytest.approx(NONE)
    assert not along.is_tolerated
    turned = one.fit(UP, turn_by(np.array([0.0, 0.0, 0.1])))
    assert turned.misfit == pytest.approx(0.1**2 / (TILT**2 + MARKERS**2))
    assert turned.tilt == pytest.approx([0.0, 0.0, 0.1 * TILT**2 / (TILT**2 + MARKERS**2)])
    assert turned.offset == pytest.approx(NONE)
    stiff = TILT**-2 + MARKERS**-2
    across = one.fit(UP + np.array([0.01, 0.0, 0.0]), np.eye(3))
    assert across.misfit == pytest.approx(0.01**2 / (OFFSET**2 + LENGTH**2 / stiff))
    tilt = 0.01 * LENGTH / OFFSET**2 / (stiff + LENGTH**2 / OFFSET**2)
    assert across.tilt == pytest.approx([0.0, tilt, 0.0])
    assert across.offset == pytest.approx([0.01 - tilt * LENGTH, 0.0, 0.0])
    sideways = one.fit(UP + np.array([0.0, 0.01, 0.0]), np.eye(3))
    assert sideways.tilt == pytest.approx([-tilt, 0.0, 0.0])


def test_other_tolerances_take_the_place_of_the_familys_own_and_two_is_tolerated() -> None:
    one = family()
    position = UP + np.array([0.0, 0.0, 0.006])
    assert one.fit(position, np.eye(3), Tolerances(TILT, 0.012, MARKERS)).misfit == pytest.approx(0.25)
    for misfit, borne in ((2.0, True), (2.0001, False)):
        assert Fit(misfit, 0.0, 1.0, UP, NONE, NONE).is_tolerated is borne


def test_the_nearest_rest_is_told_with_its_weight_and_stiffness() -> None:
    many = family((0.0, 0.0, 0.5), (0.1, 0.0, 0.45), (0.2, 0.0, 0.4))
    for index in range(3):
        fit = many.fit(many.positions[index] + np.array([0.0, 0.001, 0.0]), np.eye(3))
        assert (fit.weight, fit.stiffness) == (0.01 * index, 1.0 + index)
        assert fit.position == pytest.approx(many.positions[index])


def test_the_largest_weight_is_a_part_of_the_rods_own_mass_and_stiffness() -> None:
    config = parse_config("", "test")
    parameters = rod_from_section(config.rod, 0.01).parameters
    mass = parameters.mass_per_length * 0.5
    stiff = 190e9 * math.pi * 1e-3**4 / 4.0 / (0.25 * 9.81)
    assert largest_weight(parameters) == pytest.approx(1.2 * (mass + stiff), rel=1e-3)
    assert largest_weight(replace(parameters, gravity=(0.0, 0.0, 0.0))) == pytest.approx(1.2 * mass)


@pytest.fixture
def fresh() -> None:
    """Families are kept: compute them anew."""
    rest_family.cache_clear()


@pytest.mark.usefixtures("fresh")
def test_a_configured_family_spans_weights_and_stiffnesses_from_the_rods_own_statics() -> None:
    config = parse_config(
        "[commissioning]\nweight_max = 0.031\nstiffness = 0.25\ntilt = 0.02\noffset = 0.01\norientation = 0.3\n", "test"
    )
    rod = rod_from_section(config.rod, 0.01)
    found = configured_rests(config, rod.parameters)
    assert found is not None
    assert (found.length, found.tolerances) == (0.5, Tolerances(0.02, 0.005, 0.3))
    assert found.weights.min() == 0.0
    assert found.weights.max() == pytest.approx(0.031)
    assert (found.stiffnesses.min(), found.stiffnesses.max()) == pytest.approx((0.75, 1.25))
    for stiffness in (0.75, 1.25):
        for weight in (0.0, 0.031):
            index = int(np.argmin(np.abs(found.stiffnesses - stiffness) + np.abs(found.weights - weight)))
            position, rotation = rest(stiffness, weight)
            assert found.positions[index] == pytest.approx(position, abs=1e-6)
            assert found.rotations[index] == pytest.approx(rotation, abs=1e-6)
    places = zip(found.stiffnesses.tolist(), found.weights.tolist(), found.positions, strict=True)
    for stiffness, weight, position in list(places)[::37]:  # linear between the grid's equilibria
        assert position == pytest.approx(rest(stiffness, weight)[0], abs=2e-4)
    turns = found.rotations @ found.rotations.transpose(0, 2, 1)
    assert np.abs(turns - np.eye(3)).max() < 1e-12
    off = parse_config("[commissioning]\nrest = false\n", "test")
    assert configured_rests(off, rod.parameters) is None


@pytest.mark.usefixtures("fresh")
def test_a_family_is_of_the_configured_scheme_and_bears_the_robots_largest_weight() -> None:
    config = parse_config('[rod]\nspace = "euler"\nnodes = 23\n', "test")
    rod = rod_from_section(config.rod, 0.01)
    found = configured_rests(config, rod.parameters)
    assert found is not None
    assert found.weights.max() == pytest.approx(largest_weight(rod.parameters))
    slack = np.zeros(4)
    for index in (int(np.argmin(found.weights + np.abs(found.stiffnesses - least))) for least in (0.0, 9.0)):
        section = config.rod.model_copy(
            update={"youngs_modulus": float(found.stiffnesses[index]) * config.rod.youngs_modulus}
        )
        one = rod_from_section(section, 0.01)
        assert found.positions[index] == pytest.approx(one.tip(one.solve_static(slack)).position, abs=1e-9)


@pytest.mark.usefixtures("fresh")
def test_a_family_ends_where_a_weight_has_no_solution_and_there_is_none_without_a_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = parse_config("[commissioning]\nweight_max = 0.032\n", "test")
    parameters = rod_from_section(config.rod, 0.01).parameters
    solve = Rod.solve_static

    def within(most: float) -> None:
        def limited(self: Rod, tensions: Array, **loads: Any) -> Any:
            if np.linalg.norm(loads["tip_force"]) > most * 9.81:
                raise ConvergenceError("no equilibrium", 0.0, 1.0, 60)
            return solve(self, tensions, **loads)

        monkeypatch.setattr(Rod, "solve_static", limited)

    within(0.017)  # in steps of 2 g
    found = configured_rests(config, parameters)
    assert found is not None
    assert found.weights.max() == pytest.approx(0.016)
    rest_family.cache_clear()
    within(-1.0)
    with pytest.raises(ConvergenceError):
        configured_rests(config, parameters)


@pytest.mark.usefixtures("fresh")
def test_a_rod_without_gravity_has_one_rest() -> None:
    config = parse_config("[rod]\ngravity = [0.0, 0.0, 0.0]\n[commissioning]\nweight_max = 0.017\n", "test")
    found = configured_rests(config, rod_from_section(config.rod, 0.01).parameters)
    assert found is not None
    assert (found.weights.tolist(), found.stiffnesses.tolist()) == ([0.0], [1.0])
    assert found.positions == pytest.approx(np.array([[0.0, 0.0, 0.5]]))


def test_all_frames_of_signed_axes_are_known_by_name_the_simple_ones_first() -> None:
    frames = _frames()
    names = [one.name for one in frames]
    assert len(set(names)) == len(names) == 47
    assert [len(name) for name in names] == sorted(map(len, names))
    by_name = {one.name: one.matrix for one in frames}
    for name, matrix in {
        "with x mirrored": np.diag([-1.0, 1.0, 1.0]),
        "with y mirrored": np.diag([1.0, -1.0, 1.0]),
        "with z mirrored": np.diag([1.0, 1.0, -1.0]),
        "with all axes mirrored": -np.eye(3),
        "with x and y swapped": np.eye(3)[[1, 0, 2]],
        "with x and z swapped": np.eye(3)[[2, 1, 0]],
        "with y and z swapped": np.eye(3)[[0, 2, 1]],
    }.items():
        assert by_name[name].tolist() == matrix.tolist()
    for axis, letter in enumerate("xyz"):
        for angle in (90, -90, 180):
            turn = turn_by(math.radians(angle) * np.eye(3)[axis])
            assert by_name[f"rotated by {angle} degrees about {letter}"] == pytest.approx(turn, abs=1e-12)
    for name, matrix in by_name.items():
        if name.startswith("with axes (x, y, z) that are the model's ("):
            axes = name[name.index("'s (") + 4 : -1].split(", ")
            assert set(axes) <= {"x", "y", "z", "-x", "-y", "-z"}
            rows = [(-1.0 if one[0] == "-" else 1.0) * np.eye(3)["xyz".index(one[-1])] for one in axes]
            assert matrix == pytest.approx(np.array(rows))
    assert sum("that are the model's" in name for name in names) == 47 - 7 - 9


POSITION, ROTATION = rest()
QUARTER = turn_by(degrees(z=90))


def named(position: Array, rotation: Array) -> list[str]:
    return likely_mistakes(FAMILY, position, as_quaternion(rotation))


@pytest.mark.parametrize(
    ("position", "rotation", "words"),
    [
        (1e3 * POSITION, ROTATION, "measured = model in mm"),
        (1e2 * POSITION, ROTATION, "measured = model in cm"),
        (1e-3 * POSITION, ROTATION, "measured = model in km: is it divided by 1000 twice?"),
        (POSITION / 0.0254, ROTATION, "measured = model in inches"),
        (0.8 * POSITION, ROTATION, "lengths are 0.8 of the model's: is rod.length right?"),
        (POSITION + np.array([0.03, 0.0, 0.0]), ROTATION, "base +30 mm along x off"),
        (POSITION + np.array([0.0, -0.03, 0.0]), ROTATION, "base -30 mm along y off"),
        (POSITION + np.array([0.02, 0.03, -0.03]), ROTATION, "base (+20, +30, -30) mm off"),
        (QUARTER @ POSITION, QUARTER @ ROTATION, "measured = model rotated by 90 degrees about z"),
        (turn_by(degrees(x=40)) @ POSITION, turn_by(degrees(x=40)) @ ROTATION,
         "rotated by 40 degrees about x: is the base's frame turned?"),
        (POSITION, turn_by(degrees(x=25)) @ ROTATION,
         "only its orientation is off, rotated by 25 degrees about x: do the markers' axes lie along the tip's?"),
        (POSITION, turn_by(degrees(z=-40)) @ ROTATION,
         "only its orientation is off, rotated by -40 degrees about z: do the markers' axes lie along the tip's?"),
        (turn_by(degrees(x=-15)) @ POSITION, turn_by(degrees(x=-15)) @ ROTATION,
         "rotated by -15 degrees about x: is the base's frame turned?"),
        (np.array([0.0, 0.0, 0.5]), np.eye(3),
         "the arm is straight: is it held, or does rod.gravity point another way?"),
    ],
)  # fmt: skip
def test_a_mistake_is_named_in_whole(position: Array, rotation: Array, words: str) -> None:
    assert words in named(position, rotation)
    assert 1 <= len(named(position, rotation)) <= 2


def test_an_inverted_orientation_and_another_order_are_named() -> None:
    turned = turn_by(degrees(y=-25)) @ turn_by(degrees(z=0))
    fit = FAMILY.fit(POSITION, ROTATION)
    assert fit.is_tolerated
    assert "measured = model with its orientation inverted (base seen from the tip)" in named(POSITION, ROTATION.T)
    rolled = rotation_matrix(np.roll(as_quaternion(ROTATION), -1))
    assert "measured = model with its quaternion in the order x y z w" in named(POSITION, rolled)
    assert named(POSITION, turned @ ROTATION)


def test_what_nothing_explains_is_said_as_a_distance() -> None:
    (at_base,) = named(np.array([0.009, 0.0, 0.0]), turn_by(degrees(z=77)))
    assert at_base == "the tip is at the base: are the units right, or is it the base's own pose?"
    assert "at the base" not in named(np.array([0.011, 0.0, 0.0]), turn_by(degrees(z=77)))[0]
    (far,) = named(np.array([0.2, 0.1, 0.3]), turn_by(degrees(x=100, y=40)))
    assert far.startswith("nothing simple: tip (")
    assert far.endswith(
        "mm from the nearest rest; is it another robot's pose, is the arm held, or a tendon still pulled?"
    )


def test_a_straight_arm_is_one_within_two_hundredths_of_its_length_and_the_tilt_that_is_tolerated() -> None:
    straight = np.array([0.0, 0.0, 0.5])
    words = ["the arm is straight: is it held, or does rod.gravity point another way?"]
    assert named(straight + np.array([0.0, 0.0099, 0.0]), np.eye(3)) == words
    assert named(straight + np.array([0.0, 0.0101, 0.0]), np.eye(3)) != words
    tilt = FAMILY.tolerances.tilt
    assert named(straight, turn_by(np.array([0.0, 0.99 * tilt, 0.0]))) == words
    assert named(straight, turn_by(np.array([0.0, 1.01 * tilt, 0.0]))) != words
    may = family((0.0, 0.0, 0.5), (0.2, 0.0, 0.4))
    assert likely_mistakes(may, straight, (1.0, 0.0, 0.0, 0.0)) != words  # where it may rest so


def watched(position: Array, rotation: Array, count: int = 10) -> RestWatch:
    watch, (x, y, z) = RESTLESS, position.tolist()
    for _ in range(count):
        watch = watch.add((x, y, z), as_quaternion(rotation), 25)
    return watch


def test_an_objection_tells_place_distance_angle_and_mistakes() -> None:
    assert rest_objection(FAMILY, RESTLESS) == "the tip has not been seen at rest yet: ask again in a moment"
    assert rest_objection(FAMILY, watched(POSITION, ROTATION)) == ""
    tip = POSITION + np.array([0.0, 0.03, 0.0])
    x, y, z = tip * 1e3
    said = rest_objection(FAMILY, watched(tip, ROTATION))
    assert said.startswith(
        f"the arm does not rest as the model does: tip at ({x:.0f}, {y:.0f}, {z:.0f}) mm, 30 mm and 0 degrees from "
        "the nearest rest; "
    )
    assert "; or: " in said or "base +30 mm along y off" in said
    turned = rest_objection(FAMILY, watched(POSITION, turn_by(degrees(z=40)) @ ROTATION))
    assert "mm, 0 mm and 40 degrees from the nearest rest; " in turned
    moving = watched(POSITION, ROTATION, 25).add((0.3, 0.0, 0.3), as_quaternion(ROTATION), 25)
    moved = moving.moved(FAMILY.length) * 1e3
    spot = replace(moving.now, count=5, position=(1.5, 0.0, 1.5))
    fresh = RestWatch(moving.cycles, spot, moving.before)
    assert moved > 0.0
    assert rest_objection(FAMILY, fresh) == (
        f"the tip is moving (by {moved:.0f} mm in a quarter of a second): wait until it rests"
    )
