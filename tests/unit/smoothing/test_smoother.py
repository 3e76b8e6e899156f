"""The smoother on motions drawn from what it assumes: nearer to the truth than the filter, and rightly sure."""

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.offline.smoothing.linear import smooth
from tendond.offline.smoothing.passes import PASSES, SmoothedStretch, run_forward, smooth_stretch
from tendond.offline.smoothing.results import POINTS, known
from tendond.offline.smoothing.summary import summarise
from tests.unit.smoothing.drawn import Drawn, drawn, estimator_of, tensions_of

Array = NDArray[np.float64]

SEEDS, CYCLES = 24, 100


@pytest.fixture(scope="module")
def runs() -> list[tuple[Drawn, SmoothedStretch]]:
    """Motions, smoothed."""
    estimator, found = estimator_of(), []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        one = drawn(estimator, tensions_of(estimator, CYCLES, rng), rng)
        found.append((one, smooth_stretch(estimator, one.model.stretch)))
    return found


def rms(off: list[Array]) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.concatenate(off) ** 2)))


def test_the_smoothed_tip_and_force_are_nearer_to_the_truth_than_the_filters(
    runs: list[tuple[Drawn, SmoothedStretch]],
) -> None:
    force = runs[0][0].model.estimator.errors.force
    tips = [np.array([state.position for state in one.truth.states]) for one, _ in runs]
    smoothed_tip = [np.array([state.position for state in found.path.states]) for _, found in runs]
    filtered = rms([found.forward.tip - tip for (_, found), tip in zip(runs, tips, strict=True)])
    assert rms([a - b for a, b in zip(smoothed_tip, tips, strict=True)]) < 0.75 * filtered
    filtered = rms([(found.forward.errors - one.truth.errors)[:, force] for one, found in runs])
    assert rms([(found.path.errors - one.truth.errors)[:, force] for one, found in runs]) < 0.7 * filtered


def test_95_percent_bands_hold_90_to_98_percent(runs: list[tuple[Drawn, SmoothedStretch]]) -> None:
    """Of shape, force, errors of tensions, moments and stiffness, together: those of one run are not independent."""
    errors, within = runs[0][0].model.estimator.errors, []
    for one, found in runs:
        spread = np.sqrt(np.einsum("kii->ki", found.found.covariance))
        held = np.abs(found.path.errors - one.truth.errors) <= 1.96 * spread
        within.append(np.hstack((held[:, errors.strain], held[:, one.model.causes])))
    assert 0.9 <= float(np.mean(np.concatenate(within))) <= 0.98


def test_the_shape_is_within_its_bands_along_the_whole_backbone(runs: list[tuple[Drawn, SmoothedStretch]]) -> None:
    """By the bands without what no error describes, which a drawn motion has not."""
    held, off, filtered = [], [], []
    for one, found in runs[:6]:
        quantities, rod = known(found), one.model.estimator.rod
        names = [*(f"shape.{i}" for i in range(POINTS - 1)), "tip"]
        shape = np.stack([quantities[name].value for name in names], axis=1)
        spread = np.stack([quantities[name].deviation for name in names], axis=1)
        spread = np.sqrt(spread**2 - one.model.estimator.noise.unmodelled**2)
        truth = np.array([rod.curve(state, POINTS + 1)[1:] for state in one.truth.states])
        filter_path = one.model.follow(found.forward.errors)
        held.append(np.abs(shape - truth) <= 1.96 * spread + 1e-6)
        off.append((shape - truth).ravel())
        filtered.append(np.array([rod.curve(state, POINTS + 1)[1:] for state in filter_path.states]) - truth)
    assert 0.9 <= float(np.mean(np.concatenate(held))) <= 0.99
    assert rms(off) < 0.75 * rms([one.ravel() for one in filtered])


def test_what_poses_of_the_tip_do_not_tell_is_said() -> None:
    """A force along a bent backbone moves the tip little; short of a motion, errors of tensions look like a force."""
    estimator, rng = estimator_of(), np.random.default_rng(4)
    slack = summarise(smooth_stretch(estimator, drawn(estimator, np.zeros((10, 4)), rng).model.stretch))
    assert "force x and force z" in slack.alike
    assert slack.unmeasured == ()
    taut = summarise(smooth_stretch(estimator, drawn(estimator, np.full((10, 4), 2.0), rng).model.stretch))
    assert any(name.startswith("tension") for name in taut.unmeasured)
    assert not {*taut.unmeasured} & {"force x", "force y"}


def test_no_load_is_said_to_have_come_where_none_did(runs: list[tuple[Drawn, SmoothedStretch]]) -> None:
    assert all(found.jumps == () for _, found in runs)


def test_innovations_have_the_spread_that_is_expected_of_them(runs: list[tuple[Drawn, SmoothedStretch]]) -> None:
    square, numbers = (sum(getattr(found.found, name) for _, found in runs) for name in ("square", "numbers"))
    assert abs(square / numbers - 1.0) < 4.0 * np.sqrt(2.0 / numbers)


def test_each_smoother_changes_the_path_less_than_the_one_before() -> None:
    estimator, rng = estimator_of(), np.random.default_rng(11)
    model = drawn(estimator, tensions_of(estimator, CYCLES, rng), rng).model
    errors, changes = run_forward(model).errors, []
    for _ in range(PASSES + 2):
        path = model.follow(errors)
        found = smooth(model.problem(path))
        errors = path.errors + found.mean
        variance = np.einsum("kii->ki", found.covariance)
        changes.append(rms([found.mean[variance > 0.0] / np.sqrt(variance[variance > 0.0])]))
    assert all(after < 0.4 * before for before, after in pairwise(changes)), changes
