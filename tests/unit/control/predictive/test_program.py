"""The quadratic program: optimal, within limits, and what it says where it is not."""

import numpy as np
import pytest
from scipy.optimize import Bounds as Box
from scipy.optimize import LinearConstraint, minimize

from tendond.daemon.control.predictive import program
from tendond.daemon.control.predictive.program import Rows, solve

RNG = np.random.default_rng(3)


def random_program(n: int = 6, r: int = 8) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, Rows]:
    root = RNG.normal(size=(n, n))
    matrix = RNG.normal(size=(r, n))
    rows = Rows(matrix, np.full(r, -0.4), np.full(r, 0.4))
    return root @ root.T + 0.1 * np.eye(n), RNG.normal(size=n), np.full(n, -0.5), np.full(n, 0.5), rows


def cost(change: np.ndarray, hessian: np.ndarray, gradient: np.ndarray) -> float:
    return float(0.5 * change @ hessian @ change + gradient @ change)


def test_the_solution_is_that_of_a_plain_method() -> None:
    for _ in range(5):
        hessian, gradient, low, high, rows = random_program()
        found = solve(hessian, gradient, low, high, [rows], 200)
        plain = minimize(
            cost,
            np.zeros(6),
            args=(hessian, gradient),
            method="SLSQP",
            bounds=Box(low, high),
            constraints=[LinearConstraint(rows.matrix, rows.lower, rows.upper)],
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert found.found
        assert not found.relaxed
        assert found.cost == pytest.approx(plain.fun, abs=1e-7)
        assert found.change == pytest.approx(plain.x, abs=1e-4)


def test_rows_that_contradict_each_other_are_met_as_nearly_as_possible_and_bounds_stay_hard() -> None:
    rows = Rows(np.eye(2), np.array([0.9, -9.0]), np.array([0.9, 9.0]))
    found = solve(np.eye(2), np.zeros(2), np.full(2, -0.5), np.full(2, 0.5), [rows], 100)
    assert found.found
    assert found.relaxed
    assert found.change == pytest.approx([0.5, 0.0], abs=1e-6)


def test_a_spent_budget_gives_no_change() -> None:
    hessian, gradient, low, high, rows = random_program()
    found = solve(hessian, 100.0 * gradient, low, high, [rows], 1)
    assert not found.found
    assert found.change.tolist() == [0.0] * 6
    assert found.iterations <= 1


def test_the_same_program_has_the_same_solution_to_the_last_bit() -> None:
    program = random_program()
    one = solve(*program[:4], [program[4]], 200)
    solve(*random_program()[:4], [program[4]], 200)
    two = solve(*program[:4], [program[4]], 200)
    assert one.change.tobytes() == two.change.tobytes()


def test_the_solver_has_room_for_as_many_limits_as_it_may_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    """DAQP allocates for unknowns and soft limits, and adds one limit in an iteration at most, without a look."""
    room: list[tuple[int, int]] = []

    def spied(hessian: np.ndarray, *given: np.ndarray, **options: float) -> object:
        sense = given[-1]
        room.append((len(hessian) + int(np.count_nonzero(sense & program.SOFT)), int(options["iter_limit"])))
        return plain(hessian, *given, **options)

    plain = program.solver()
    monkeypatch.setattr(program, "solver", lambda: spied)
    contradictory = Rows(np.eye(2), np.array([0.9, -9.0]), np.array([0.9, 9.0]))
    for rows in ([contradictory], []):
        found = solve(np.eye(2), np.ones(2), np.full(2, -0.5), np.full(2, 0.5), rows, 300)
        assert found.found
        assert found.active <= 4  # not the rows that only make room
    assert len(room) == 3  # the first one twice: relaxed as well
    assert all(capacity >= limit for capacity, limit in room)
