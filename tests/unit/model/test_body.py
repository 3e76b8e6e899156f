"""Points of the body, their trajectory, their motion ahead and their clearances, beside the plain computations."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.body.ahead import look_ahead
from tendond.model.body.clearance import Kept, SurfaceRows, find_clearance
from tendond.model.body.points import PointWeights, find_points
from tendond.model.body.trajectory import Trajectory
from tendond.model.errors import ConvergenceError
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.selection import model_rod
from tendond.model.strain.kinematics import empty_shape
from tendond.schemas.config.rig import check_config

Array = NDArray[np.float64]

PULL = np.array([8.0, 1.0, 2.0, 1.0])


def arm(friction: float = 0.0) -> GeneralRod:
    rod = model_rod(check_config({"rod": {"tendon_friction": friction}, "control": {"solver": "general"}}, "test"))
    assert isinstance(rod, GeneralRod)
    return rod


def weights_of(rod: GeneralRod) -> PointWeights:
    return PointWeights(*rod.backbone.weights(rod.robot.length * np.array([0.3, 0.75, 1.0])))


def test_points_and_their_derivatives_are_those_of_the_backbone() -> None:
    rod = arm()
    state, weights, n = rod.solve_static(PULL), weights_of(rod), rod.strain_rod.modes
    points, jacobians, room = np.empty((3, 3)), np.empty((3, 3, n)), empty_shape(rod.strain_rod.layout)
    q = state.strain.strain

    def at(strain: Array) -> Array:
        find_points(rod.strain_rod.layout, strain, room, weights, points, jacobians)
        return points.copy()

    here = at(q)
    derivatives = jacobians.copy()
    curve = rod.backbone.curve(state.strain, 101)
    np.testing.assert_allclose(here, curve[[30, 75, 100]], atol=1e-12)
    for mode in range(n):
        step = np.zeros(n)
        step[mode] = 1e-6
        np.testing.assert_allclose((at(q + step) - at(q - step)) / 2e-6, derivatives[:, :, mode], atol=1e-7)


@pytest.mark.parametrize("friction", [0.0, 0.2])
def test_a_trajectory_is_step_after_step_of_the_rod(friction: float) -> None:
    rod = arm(friction)
    weights, state = weights_of(rod), rod.step(rod.solve_static(PULL), 1.1 * PULL)
    pulls = PULL * np.linspace(1.1, 1.6, 8)[:, None]
    strains, points, last = Trajectory(rod.strain_rod, weights, 1e-8).follow(state.strain, rod.loads(PULL), pulls)
    now = state
    for index, tensions in enumerate(pulls):
        now = rod.step(now, tensions)
        np.testing.assert_allclose(strains[index], now.strain.strain, atol=1e-7)
        np.testing.assert_allclose(points[index, -1], now.position, atol=1e-8)
    np.testing.assert_allclose(last.rate, now.strain.rate, atol=1e-4)
    if friction > 0.0:
        assert last.pulls is not None
        assert now.strain.pulls is not None
        np.testing.assert_allclose(last.pulls, now.strain.pulls, atol=1e-5)


def test_a_trajectory_that_is_not_finite_is_refused() -> None:
    rod = arm()
    pulls = np.array([PULL, np.full(4, np.nan)])
    with pytest.raises(ConvergenceError, match="not finite"):
        Trajectory(rod.strain_rod, weights_of(rod), 1e-8).follow(rod.solve_static(PULL).strain, rod.loads(PULL), pulls)


@pytest.mark.parametrize("lag", [0.0, 0.6])
def test_the_motion_ahead_is_that_of_single_steps(lag: float) -> None:
    generator = np.random.default_rng(4)
    n, m, doublings, each, later = 3, 2, 1, 5, 3
    a = generator.normal(size=(2 * n, 2 * n))
    a *= 0.95 / np.max(np.abs(np.linalg.eigvals(a)))
    b, coming = generator.normal(size=(2 * n, m)), generator.normal(size=2 * n)
    points, bends = generator.normal(size=(6, n)), generator.normal(size=(2, n))
    moves, turns = np.empty((each + later, 6, 1 + m)), np.empty((each + later, 2, 1 + m))
    assert look_ahead(a, b, coming, lag, doublings, each, later, points, bends, moves, turns)
    change = np.array([0.7, -0.4])
    y, found = np.zeros(2 * n), {}
    times = [2 * (k + 1) for k in range(each)]
    for more in range(later):
        times.append(times[-1] + 8 * 2**more)
    for step in range(times[-1]):
        y = a @ y + b @ ((1.0 - lag ** (step + 1)) * change) + coming
        found[step + 1] = y[:n]
    for k, time in enumerate(times):
        np.testing.assert_allclose(moves[k] @ [1.0, *change], points @ found[time], atol=1e-9)
        np.testing.assert_allclose(turns[k] @ [1.0, *change], bends @ found[time], atol=1e-9)


def test_a_motion_that_grows_beyond_all_numbers_is_not_finite() -> None:
    a, moves, turns = 1e40 * np.eye(2), np.empty((9, 3, 2)), np.empty((9, 0, 2))
    assert not look_ahead(a, np.ones((2, 1)), np.ones(2), 0.0, 3, 6, 3, np.ones((3, 1)), np.empty((0, 1)), moves, turns)


def test_clearances_lose_what_errors_take_and_their_slopes_are_derivatives() -> None:
    rows = SurfaceRows(
        np.array([0, 1, 1]), np.array([[0.6, 0.0, 0.8]]), np.array([0.1]), np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
        np.array([0.2, 3.0]), np.array([1.0, -1.0]),
    )  # fmt: skip
    points, moves = np.array([[0.5, 0.1, 0.4], [0.3, -0.2, 0.6]]), np.zeros((2, 2, 3, 1))
    moves[0, :, :, 0], moves[1, :, :, 0] = [[0.01, 0.0, 0.0], [0.0, 0.03, 0.0]], [[0.02, 0.0, 0.0], [0.0, 0.03, 0.04]]
    bends, turns = np.array([[3e-3, 4e-3]]), np.zeros((2, 1, 2, 1))
    turns[1, 0, :, 0] = [3e-3, 4e-3]

    def found(kept: Kept, moves: Array) -> tuple[Array, Array, Array, Array]:
        out = np.empty((2, 4)), np.empty((2, 3, 3)), np.empty((2, 1, 2)), np.empty(4)
        find_clearance(rows, kept, points, bends, moves, turns, np.ones(1), *out)
        return out

    bare, _, _, reach = found(Kept(0.0, 0.0, 0.0, 0.02), moves)
    at = points + moves[..., 0]
    expected = at[:, 0] @ [0.6, 0.0, 0.8] - 0.1
    np.testing.assert_allclose(bare[:, 0], expected)
    np.testing.assert_allclose(bare[:, 1], np.linalg.norm(at[:, 1] - [0.0, 0.0, 1.0], axis=1) - 0.2)
    np.testing.assert_allclose(bare[:, 2], 3.0 - np.linalg.norm(at[:, 1] - [1.0, 0.0, 0.0], axis=1))
    np.testing.assert_allclose(bare[:, 3], [0.015, 0.01])
    np.testing.assert_allclose(reach, [0.02, 0.05, 0.05, 5e-3])
    kept = Kept(0.004, 0.1, 0.5, 0.02)
    clear, slopes, _, _ = found(kept, moves)
    np.testing.assert_allclose(clear[:, 0], bare[:, 0] - 0.004 - [0.001, 0.002] - 0.005)
    np.testing.assert_allclose(clear[:, 1], bare[:, 1] - 0.004 - [0.003, 0.005] - 0.02)
    np.testing.assert_allclose(clear[:, 3], [0.02 - 1.1 * 5e-3, 0.02 - 1.1 * 0.01 - 0.1 * 5e-3])
    without = kept._replace(delay=0.0)
    for axis in range(3):
        aside = moves.copy()
        aside[1, 1, axis, 0] += 1e-6
        difference = (found(without, aside)[0] - found(without, moves)[0])[1, 1:3] / 1e-6
        np.testing.assert_allclose(slopes[1, 1:3, axis], difference, atol=1e-4)
