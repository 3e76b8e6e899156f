"""Standard errors against linear problems with known solutions, with white and with coloured errors."""

import numpy as np
import pytest

from tendond.offline.identification.fitting.statistics import Statistics, bandwidth, covariance, long_run

COUNT = 1500


def line(seed: int, rho: float) -> tuple[np.ndarray, np.ndarray, Statistics]:
    """Estimates of a line through AR(1) errors, the truth, and what the statistics say of them."""
    random = np.random.default_rng(seed)
    x = np.column_stack([np.ones(COUNT), np.sin(0.01 * np.arange(COUNT))])
    error = np.zeros(COUNT)
    shock = random.standard_normal(COUNT)
    for k in range(1, COUNT):
        error[k] = rho * error[k - 1] + shock[k]
    truth = np.array([1.0, -2.0])
    y = x @ truth + error
    estimate = np.linalg.lstsq(x, y, rcond=None)[0]
    residual = x @ estimate - y
    scores = [x * residual[:, None]]
    white = float(np.mean(residual**2)) * (x.T @ x)
    return estimate, truth, covariance(x.T @ x, scores, white, ["a", "b"], np.full(2, 10.0), COUNT)


def test_with_white_errors_they_are_the_textbooks() -> None:
    estimate, _, found = line(1, 0.0)
    x = np.column_stack([np.ones(COUNT), np.sin(0.01 * np.arange(COUNT))])
    textbook = np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    assert found.deviations == pytest.approx(textbook, rel=0.15)
    assert found.inflation == pytest.approx(np.ones(2), abs=0.15)
    assert found.unidentifiable == ()
    assert estimate.shape == (2,)


def test_with_coloured_errors_the_truth_is_within_two_of_them_as_often_as_it_should_be() -> None:
    hits, naive, count = 0, 0, 0
    for seed in range(150):
        estimate, truth, found = line(seed, 0.8)
        off = np.abs(estimate - truth)
        hits += int(np.sum(off <= 2.0 * found.deviations))
        naive += int(np.sum(off <= 2.0 * found.deviations / found.inflation))
        count += 2
    assert 0.90 <= hits / count <= 0.99
    assert naive / count < 0.6
    # An AR(1) error of 0.8 makes the error of a slow column sqrt((1 + 0.8) / (1 - 0.8)) = 3 times that of a white one.
    assert np.mean([line(seed, 0.8)[2].inflation.max() for seed in range(20)]) == pytest.approx(3.0, rel=0.25)


def test_stretches_of_data_are_not_taken_for_one() -> None:
    random = np.random.default_rng(0)
    one, other = random.standard_normal((400, 2)) + 1.0, random.standard_normal((400, 2)) - 1.0
    apart = long_run([one, other])
    assert apart == pytest.approx(long_run([one]) + long_run([other]))
    assert bandwidth(random.standard_normal((400, 2))) <= 4
    assert bandwidth(np.cumsum(random.standard_normal((400, 2)), axis=0)) > 20


def test_two_parameters_that_do_the_same_are_not_identifiable() -> None:
    random = np.random.default_rng(2)
    column = random.standard_normal(500)
    x = np.column_stack([column, column, random.standard_normal(500)])
    residual = random.standard_normal(500)
    found = covariance(x.T @ x, [x * residual[:, None]], x.T @ x, ["one", "same", "free"], np.full(3, 10.0), 500)
    assert np.isinf(found.deviations[:2]).all()
    assert np.isfinite(found.deviations[2])
    assert set(found.unidentifiable[0].names) == {"one", "same"}


def test_a_parameter_that_is_poorly_identifiable_is_named_with_the_one_that_hides_it() -> None:
    random = np.random.default_rng(3)
    column = random.standard_normal(2000)
    x = np.column_stack([column, column + 1e-3 * random.standard_normal(2000)])
    residual = random.standard_normal(2000)
    found = covariance(x.T @ x, [x * residual[:, None]], x.T @ x, ["one", "other"], np.full(2, 0.5), 2000)
    assert set(found.unidentifiable[0].names) == {"one", "other"}
    assert found.unidentifiable[0].deviation > 1.0
    assert abs(found.correlation[0, 1]) > 0.99


def test_what_the_time_step_may_be_found_as_is_one_more_deviation_in_one_direction() -> None:
    random = np.random.default_rng(3)
    x, residual = random.standard_normal((COUNT, 2)), random.standard_normal(COUNT)
    scores, names, max_deviation = [x * residual[:, None]], ["a", "b"], np.array([0.5, 2.0])
    plain = covariance(x.T @ x, scores, x.T @ x, names, max_deviation, COUNT)
    remaining = np.array([0.1, -0.2])
    more = covariance(x.T @ x, scores, x.T @ x, names, max_deviation, COUNT, remaining)
    assert more.covariance == pytest.approx(plain.covariance + np.outer(remaining, remaining))
    assert more.correlation == pytest.approx(plain.correlation)  # of noise alone
    assert more.inflation == pytest.approx(plain.inflation)
