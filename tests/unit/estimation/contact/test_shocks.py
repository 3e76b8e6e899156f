"""Score, information and statistic of contacts, against least squares over whole stretches of data."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.estimation.contact.responses import find_responses
from tendond.model.estimation.contact.shocks import PARTS
from tendond.model.estimation.contact.signatures import carry, heed, weigh, whiten
from tendond.model.estimation.contact.state import Trace
from tendond.model.estimation.contact.weighing import AXIAL, Weigher
from tendond.model.estimation.kalman.factored import factors_of
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.stations import Stations
from tests.unit.strain.robots import paper

Array = NDArray[np.float64]

K, N, MEASURED, CYCLES, DEVIATION = 4, 11, 6, 14, 2.0


@pytest.fixture(scope="module")
def stations() -> Stations:
    return GeneralRod(paper(), 0.01).stations


def decays() -> Array:
    return np.linspace(1.0, 0.9, N - 2 * K)


def traces_of(stations: Stations, seed: int, innovations: Array | None = None) -> list[Trace]:
    """Random linear systems, one a cycle; without innovations unless they are given."""
    rng, p = np.random.default_rng(seed), len(stations.at)
    axial = np.zeros((p, 3))
    axial[:, 2] = 1.0
    traces = []
    for cycle in range(CYCLES):
        top = 0.3 * rng.normal(size=(2 * K, N))
        push, white = rng.normal(size=(2 * K, 3 * p)), rng.normal(size=(MEASURED, N))
        gain = 0.05 * rng.normal(size=(MEASURED, N))
        seen = rng.normal(size=MEASURED) if innovations is None else innovations[cycle]
        traces.append(Trace(top, push, white, gain, seen, axial, np.zeros(4)))
    return traces


def signatures(traces: list[Trace], station: int, onset: float) -> Array:
    """What a force of 1 N from an onset on leaves in all innovations, shape (CYCLES * MEASURED, 3)."""
    errors, found = np.zeros((N, 3)), []
    for cycle, trace in enumerate(traces):
        whole = np.zeros((N, N))
        whole[: 2 * K], whole[range(2 * K, N), range(2 * K, N)] = trace.top, decays()
        push = np.zeros((N, 3))
        push[: 2 * K] = trace.push[:, 3 * station : 3 * station + 3]
        errors = whole @ errors + min(max(cycle - onset, 0.0), 1.0) * push
        found.append(trace.white @ errors)
        errors = errors - trace.gain.T @ found[-1]
    return np.concatenate(found)


def by_least_squares(traces: list[Trace], station: int, onset: float) -> tuple[float, Array]:
    """Statistic and force of the regression of all innovations on a signature, with prior rows."""
    rows = np.vstack((signatures(traces, station, onset), np.diag([1.0, 1.0, np.sqrt(1.0 + AXIAL)]) / DEVIATION))
    right = np.concatenate([*(trace.innovation for trace in traces), np.zeros(3)])
    force, *_ = np.linalg.lstsq(rows, right, rcond=None)
    return float(right @ right - np.sum((right - rows @ force) ** 2)), force


def test_the_likeliest_onset_of_each_place_is_that_of_least_squares(stations: Stations) -> None:
    traces = traces_of(stations, 1)
    weighed = Weigher(stations, decays(), N, DEVIATION).weigh(traces, CYCLES - 1)
    for station in range(len(stations.at)):
        onsets = np.arange(-1.0 + 1.0 / PARTS, CYCLES - 1 + 1e-9, 1.0 / PARTS)
        best = max((by_least_squares(traces, station, onset)[0], onset) for onset in onsets)
        assert weighed.statistic[station] == pytest.approx(best[0], rel=1e-9)
        assert weighed.onset[station] == best[1]
        assert weighed.force[station] == pytest.approx(
            by_least_squares(traces, station, best[1])[1], rel=1e-7, abs=1e-9
        )


@pytest.mark.parametrize(("station", "onset"), [(2, 3.0), (5, 6.25), (7, 4.5)])
def test_a_force_without_noise_is_found_where_and_when_it_is(stations: Stations, station: int, onset: float) -> None:
    force = np.array([0.4, -0.3, 0.0])
    plain = traces_of(stations, 2, np.zeros((CYCLES, MEASURED)))
    seen = (signatures(plain, station, onset) @ force).reshape(CYCLES, MEASURED)
    traces = traces_of(stations, 2, seen)
    weigher = Weigher(stations, decays(), N, 1e4)
    weighed = weigher.weigh(traces, CYCLES - 1)
    assert int(np.argmax(weighed.statistic)) == station
    assert weighed.onset[station] == onset
    assert weighed.force[station] == pytest.approx(force, abs=1e-6)
    assert weighed.statistic[station] == pytest.approx(np.sum(seen**2), rel=1e-6)
    fit = weigher.fit(traces, CYCLES - 1, onset, float(stations.at[station]))
    assert fit.force == pytest.approx(force, abs=1e-6)
    assert fit.statistic == pytest.approx(np.sum(seen**2), rel=1e-6)
    assert fit.statistic_of(force) == pytest.approx(fit.statistic, rel=1e-6)
    assert fit.statistic_of(-force) < 0.0


def test_a_force_between_two_stations_is_shared_by_them(stations: Stations) -> None:
    place = 0.3 * stations.at[3] + 0.7 * stations.at[4]
    weights = stations.weights(place)
    assert weights[3:5] == pytest.approx([0.3, 0.7])
    assert weights.sum() == pytest.approx(1.0)
    force = np.array([0.2, 0.5, 0.0])
    plain = traces_of(stations, 3, np.zeros((CYCLES, MEASURED)))
    seen = sum(weights[station] * signatures(plain, station, 2.0) @ force for station in (3, 4))
    traces = traces_of(stations, 3, np.asarray(seen).reshape(CYCLES, MEASURED))
    assert Weigher(stations, decays(), N, 1e4).fit(traces, CYCLES - 1, 2.0, place).force == pytest.approx(
        force, abs=1e-6
    )


def test_windows_gather_what_least_squares_would(stations: Stations) -> None:
    traces, p = traces_of(stations, 4), len(stations.at)
    errors, information, score = np.zeros((1, N, 3 * p)), np.zeros((1, p, 3, 3)), np.zeros((1, p, 3))
    for trace in traces:
        carry(trace.top, decays(), trace.push, errors, np.empty((2 * K, 3 * p)))
        heed(trace.white, trace.gain, trace.innovation, errors, np.empty((MEASURED, 3 * p)), information, score)
    force, statistic = np.empty((1, p, 3)), np.empty((1, p))
    prior = Weigher(stations, decays(), N, DEVIATION).prior(traces[-1].axial)
    weigh(information, score, prior, np.empty((3, 3)), force, statistic)
    for station in range(p):
        expected = by_least_squares(traces, station, -1.0)
        assert statistic[0, station] == pytest.approx(expected[0], rel=1e-9)
        assert force[0, station] == pytest.approx(expected[1], rel=1e-7, abs=1e-9)


def test_whitened_innovations_have_unit_variance_and_the_filters_gain() -> None:
    rng = np.random.default_rng(5)
    root = rng.normal(size=(N, N))
    covariance, rows, variance = root @ root.T, rng.normal(size=(MEASURED, N)), rng.uniform(0.5, 2.0, MEASURED)
    innovation = rng.normal(size=MEASURED)
    spread = rows @ covariance @ rows.T + np.diag(variance)
    factors, seen = factors_of(covariance), innovation.copy()
    white, gain = np.empty((MEASURED, N)), np.empty((MEASURED, N))
    assert whiten(rows, variance, seen, *factors, np.empty((2 * MEASURED, N)), white, gain)
    lower = np.linalg.cholesky(spread)
    assert white == pytest.approx(np.linalg.solve(lower, rows))
    assert seen == pytest.approx(np.linalg.solve(lower, innovation))
    assert gain.T @ seen == pytest.approx(covariance @ rows.T @ np.linalg.solve(spread, innovation))


def test_responses_solve_the_steps_system() -> None:
    rng = np.random.default_rng(6)
    root, jacobian = rng.normal(size=(K, K)), rng.normal(size=(5, 3, K + 2))
    matrix, kept, points, h = root @ root.T + np.eye(K), np.array([0, 2, 3, 5]), np.array([1, 4]), 0.01
    upper = matrix.copy()
    for i in range(K):
        for l in range(i + 1, K):
            upper[l] -= upper[l, i] / upper[i, i] * upper[i]
    found = np.empty((2 * K, 6))
    find_responses(upper, jacobian, points, kept, h, found)
    pushed = np.concatenate([jacobian[point][:, kept] for point in points]).T
    assert found[:K] == pytest.approx(np.linalg.solve(matrix, pushed))
    assert found[K:] == pytest.approx(2.0 / h * found[:K])


def test_the_place_between_stations_is_the_vertex_of_a_parabola(stations: Stations) -> None:
    from tendond.model.estimation.contact.weighing import Weighed

    weigher, at = Weigher(stations, decays(), N, DEVIATION), stations.at
    true = 0.62 * at[-1]
    statistic = 100.0 - 400.0 * ((at - true) / at[-1]) ** 2
    place, first, last = weigher.locate(Weighed(statistic, np.zeros(len(at)), np.zeros((len(at), 3))))
    assert place == pytest.approx(true, abs=1e-9)
    assert first < true < last < at[-1]
