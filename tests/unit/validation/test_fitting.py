"""Fits: known parameters come back from simulated poses, the held-out part changes nothing, and BIC selects."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.offline.validation.fitting.fit import fit
from tendond.offline.validation.fitting.identifiable import inseparable, knowledge_of
from tendond.offline.validation.fitting.problem import Problem
from tendond.offline.validation.fitting.selection import independent, select
from tendond.offline.validation.rods.parameters import BASIC
from tests.unit.validation.robots import DESIGN, TRUE, simulated, values_of

HYSTERESIS = {"yielding": 0.6, "yield_curvature": 0.4}


def test_parameters_of_a_robot_with_hysteresis_come_back() -> None:
    poses = simulated(noise=1e-5, **HYSTERESIS)
    values, solution = Problem(DESIGN, poses, (*BASIC, "yielding"), values_of()).solve()
    for name, value in TRUE.items():
        assert abs(values[name] - value) < max(0.03 * abs(value), 2e-4), name
    for name, value in HYSTERESIS.items():  # the priors' centres are 0.5 and 1
        assert abs(values[name] / value - 1.0) < 0.12, name
    assert np.sqrt(np.mean(solution.residuals**2)) < 0.05


def test_what_is_held_out_does_not_move_a_fit_by_a_bit() -> None:
    poses = simulated(**HYSTERESIS)
    other = poses.tip.copy()
    other[poses.held_out] += 0.01
    problem = Problem(DESIGN, poses, ("pose", "length"), values_of(**TRUE))
    found = problem.solve()[1].z
    np.testing.assert_array_equal(found, replace(problem, poses=replace(poses, tip=other)).solve()[1].z)


def test_a_linear_problem_is_solved_as_ridge_regression() -> None:
    rng = np.random.default_rng(1)
    matrix, target = rng.standard_normal((30, 4)), rng.standard_normal(30)
    found = fit(lambda z: matrix @ z - target, np.zeros(4))
    np.testing.assert_allclose(found.z, np.linalg.solve(matrix.T @ matrix + np.eye(4), matrix.T @ target), atol=1e-4)


def test_errors_that_follow_each_other_count_less() -> None:
    rng = np.random.default_rng(2)
    white = rng.standard_normal((4000, 3))
    slow = np.zeros_like(white)
    for i in range(1, len(white)):
        slow[i] = 0.8 * slow[i - 1] + white[i]
    assert independent(white.reshape(-1)) > 0.9 * white.size
    assert abs(independent(slow.reshape(-1)) / slow.size - 0.2 / 1.8) < 0.02  # (1 - r) / (1 + r)


def test_selection_takes_the_yielding_backbone_that_is_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "tendond.offline.validation.fitting.selection.groups_of", lambda design: [*BASIC, "yielding", "torsion"]
    )
    poses = simulated(noise=5e-5, **HYSTERESIS)
    _, _, problem, trials = select(Problem(DESIGN, poses, BASIC, values_of()))
    assert problem.groups == (*BASIC, "yielding")
    assert [(one.group, one.taken) for one in trials] == [("yielding", True), ("torsion", False)]


def test_length_and_the_bases_place_along_it_cannot_be_told_apart_without_bending() -> None:
    poses = simulated()
    still = replace(poses, command=np.full_like(poses.command, -1e-2))
    problem = Problem(DESIGN, still, ("pose", "length", "torsion"), values_of())
    residuals = problem.residuals
    solution = fit(residuals, problem.start(), iterations=1)
    pairs = [{one, other} for one, other, _ in inseparable(problem.parameters, solution)]
    assert {"length_0", "base_z"} in pairs
    knowledge = {one.name: one for one in knowledge_of(problem.parameters, solution, 1.0)}
    assert not knowledge["torsion"].identifiable
