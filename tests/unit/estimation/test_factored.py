"""The factors of the covariance against plain matrices: the Kalman filter's equations as in any textbook."""

import numpy as np
import pytest

from tendond.model.estimation.kalman.factored import Factors, correct, factors_of, propagate

N, T = 9, 4


def covariance(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(N, N))
    return np.asarray(root @ root.T)


def test_the_factors_are_those_of_the_matrix_and_of_one_without_full_rank() -> None:
    whole = covariance(0)
    assert factors_of(whole).covariance == pytest.approx(whole)
    rows = np.random.default_rng(1).normal(size=(3, N))
    assert factors_of(whole).along(rows) == pytest.approx(rows @ whole @ rows.T)
    thin = np.zeros((N, N))
    thin[2:4, 2:4] = 1.0
    assert factors_of(thin).covariance == pytest.approx(thin)


def test_a_prediction_is_a_p_a_and_q() -> None:
    rng = np.random.default_rng(2)
    top, decay, noise = rng.normal(size=(T, N)), rng.uniform(0.1, 1.0, N - T), rng.uniform(0.0, 2.0, N - T)
    whole = covariance(3)
    old = factors_of(whole)
    columns, spread = np.empty((N, N)), np.empty(N)
    weight = np.concatenate((old.spread, np.zeros(N - T)))
    propagate(top, decay, noise, old.columns, weight, np.zeros((N, 2 * N - T)), columns, spread)
    a = np.vstack((top, np.hstack((np.zeros((N - T, T)), np.diag(decay)))))
    q = np.diag(np.concatenate((np.zeros(T), noise)))
    assert Factors(columns, spread).covariance == pytest.approx(a @ whole @ a.T + q)
    assert np.array_equal(np.tril(columns), columns)  # column by column of an upper triangle
    assert np.diag(columns) == pytest.approx(np.ones(N))


def test_a_correction_is_that_of_all_rows_at_once() -> None:
    rng = np.random.default_rng(4)
    rows, lack, variance = rng.normal(size=(3, N)), rng.normal(size=3), rng.uniform(0.1, 1.0, 3)
    whole, before = covariance(5), rng.normal(size=N)
    factors, deviation = factors_of(whole), before.copy()
    nis = correct(rows, lack, variance, factors.columns, factors.spread, np.zeros((2, N)), deviation)
    expected = rows @ whole @ rows.T + np.diag(variance)
    gain = np.linalg.solve(expected, rows @ whole).T
    innovation = lack - rows @ before
    assert deviation == pytest.approx(before + gain @ innovation)
    assert factors.covariance == pytest.approx(whole - gain @ rows @ whole)
    assert nis == pytest.approx(innovation @ np.linalg.solve(expected, innovation))
    assert (factors.spread > 0.0).all()
