"""A simulator's truth at the times of the controller's cycles: interpolated by the stamps, not as it came."""

from pathlib import Path

import numpy as np
import pytest

from tendond.offline.demo.truth import cycle_times, true_tips
from tendond.offline.logs.arrays import Arrays
from tendond.schemas.config.rig import RigConfig

START, PERIOD, SPEED = 1e4, 0.01, 0.4


def run_of(age: np.ndarray, lost: int | None = None) -> Arrays:
    """A run whose tip moves along x at `SPEED`, and whose truths have an age [s]; `lost`: cycle without one."""
    ticks = np.arange(50)
    times = START + PERIOD * ticks
    stamps, poses = 1e9 * (times - age), 1e9 * (times - 0.012)
    lag = np.full(50, 0.012)
    x = SPEED * (times - age - START)
    truth = np.column_stack([x, np.zeros(50), np.ones(50)])
    if lost is not None:
        stamps[lost], truth[lost], poses[lost], lag[lost] = np.nan, np.nan, np.nan, np.nan
    arrays = {
        "tick": ticks, "inputs.pose.stamp_ns": poses, "inputs.pose_lag": lag,
        "truth.stamp_ns": stamps, "truth.position": truth,
    }  # fmt: skip
    return Arrays(Path("run.mcap"), RigConfig(), {}, arrays, {})


def test_the_age_of_a_truth_is_no_error_and_neither_is_a_lost_one() -> None:
    age = np.random.default_rng(0).uniform(0.0, 0.009, 50)
    tips = true_tips(run_of(age, lost=20), slice(5, 45))
    expected = SPEED * PERIOD * np.arange(5, 45)
    np.testing.assert_allclose(tips[:, 0], expected, atol=2e-6)
    np.testing.assert_allclose(tips[:, 2], 1.0)
    assert SPEED * float(age.max()) > 3e-3  # what it would be without


def test_beyond_the_truths_nothing_is_known_and_cycles_keep_their_time() -> None:
    run = run_of(np.full(50, 0.004), lost=3)
    assert cycle_times(run, slice(0, 50)) == pytest.approx(START + PERIOD * np.arange(50))
    assert np.isnan(true_tips(run, slice(0, 50))[-1]).all()
