"""Rests of robots of sections: their derivatives, and the one nearest to a pose."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.pose import Aim, Pose, counted, difference, miss, rotation_to, turn
from tendond.daemon.control.pose.rests import PoseRests
from tendond.model.errors import ParameterError
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import RigConfig
from tests.unit.pose.robots import rests


@pytest.mark.parametrize("which", ["two", "three"])
def test_the_jacobian_is_that_of_equilibria_under_other_tensions(which: str) -> None:
    some = rests(which)
    tension = some.preferred + np.linspace(0.0, 1.5, len(some.preferred))
    rest = some.rest(tension)
    for tendon in (0, len(tension) - 1):
        moved = tension.copy()
        moved[tendon] += 1e-3
        there = some.rest(moved, rest.state)
        assert np.allclose((there.pose.position - rest.pose.position) / 1e-3, rest.jacobian[:3, tendon], atol=2e-4)
        assert np.allclose(turn(rest.pose, there.pose, "pose") / 1e-3, rest.jacobian[3:, tendon], atol=3e-3)


@pytest.mark.parametrize(("which", "aim"), [("two", "position"), ("two", "direction"), ("three", "pose")])
def test_a_pose_that_a_rest_has_is_found_with_no_more_tension(which: str, aim: Aim) -> None:
    some = rests(which)
    n = len(some.preferred)
    start = some.rest(some.preferred)
    rng = np.random.default_rng(3)
    for _ in range(2):
        there = some.rest(1.0 + rng.uniform(0.0, 2.0, n))
        found, apart = some.find(there.pose, aim, start)
        assert apart.distance < 1e-4
        assert apart.angle < math.radians(0.1)
        assert found.tension.min() >= 1.0 - 1e-9
        assert found.tension.sum() < there.tension.sum() + 0.01


def test_beyond_reach_the_nearest_pose_is_found() -> None:
    some = rests("two")
    start = some.rest(some.preferred)
    wanted = Pose(np.array([0.0, 0.0, 0.5]), np.eye(3))
    found, apart = some.find(wanted, "position", start)
    assert apart.distance == pytest.approx(0.5 - 0.26, abs=2e-3)
    assert found.pose.position[2] > 0.25


def test_the_shooting_rod_is_refused_by_name() -> None:
    with pytest.raises(ParameterError, match=r"control\.solver = 'general'"):
        PoseRests(model_rod(RigConfig()), 1.0, 20.0, "least_tension")


def test_turns_between_poses_are_rotation_vectors_and_half_a_turn_has_one_too() -> None:
    one = Pose(np.zeros(3), Rotation.from_rotvec([0.3, -0.2, 0.9]).as_matrix())
    other = Pose(np.ones(3), Rotation.from_rotvec([0.1, 0.2, 0.0]).as_matrix() @ one.rotation)
    assert np.allclose(turn(one, other, "pose"), [0.1, 0.2, 0.0])
    small = turn(one, other, "direction")
    assert np.allclose(Rotation.from_rotvec(small).as_matrix() @ one.direction, other.direction)
    assert abs(float(small @ one.direction)) < 1e-12
    back = Pose(np.zeros(3), rotation_to(np.array([0.0, 0.0, -1.0])))
    assert np.linalg.norm(turn(Pose(np.zeros(3), np.eye(3)), back, "direction")) == pytest.approx(math.pi)
    assert miss(one, other, "across").distance == pytest.approx(math.sqrt(2.0))


@pytest.mark.parametrize("aim", ["across", "position", "direction", "pose"])
def test_the_measure_of_poses_has_the_derivative_that_is_said(aim: Aim) -> None:
    some = rests("two")
    rest = some.rest(some.preferred + 0.5)
    change = 1e-4 * np.linspace(-1.0, 1.0, len(some.preferred))
    there = some.rest(rest.tension + change, rest.state)
    moved = difference(rest.pose, there.pose, aim, some.radian)
    assert np.allclose(moved, counted(rest.jacobian, rest.pose, aim, some.radian) @ change, atol=2e-8)
