"""The learned correction of what a fit leaves: from the logs themselves, kept only if it predicts parts left out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.residual import Residual
from tendond.offline.correction.learned import along, train
from tendond.offline.identification.simulation.simulated import Simulated

Array = NDArray[np.float64]

ROWS = 4000
"""Poses that a correction is learned from, about: its features are few."""

BLOCK = 1.0
"""Length of the stretches of a log that are left out together [s]: errors of neighbours are alike."""

EVERY = 5
"""One in so many stretches tests the correction before it is learned from all."""

GAIN = 0.05
"""Part by which a correction must reduce the error of the stretches left out, to be worth its numbers."""


@dataclass(frozen=True)
class Learned:
    """A correction, and what it does where it was not learned from.

    Attributes:
        residual: correction, learned from all stretches; none where it does not help.
        before, after: distance of model and measured tip on the stretches left out, root mean square [m].
        held_out: the same of recordings that were not used, by name.
    """

    residual: Residual | None
    before: float
    after: float
    held_out: tuple[tuple[str, float, float], ...] = ()


def summary(learned: Learned) -> str:
    """Say in a line what a correction does on the stretches that it was not learned from."""
    if not np.isfinite(learned.before):
        return f"residual: none, the logs are shorter than {EVERY} stretches of {BLOCK:g} s"
    apart = f"{learned.before * 1e3:.3f} mm without, {learned.after * 1e3:.3f} mm with it, on stretches left out"
    if learned.residual is None:
        return f"residual: none, it does not predict what it was not learned from ({apart})"
    others = "".join(
        f"; {name}, held out: {before * 1e3:.3f} and {after * 1e3:.3f} mm" for name, before, after in learned.held_out
    )
    return f"residual: {apart}; no longer than {learned.residual.bound * 1e3:.2f} mm{others}"


@dataclass(frozen=True)
class _Rows:
    """Displacements [m], shape (N, n), errors, measured minus predicted [m], shape (N, 3), stretches, shape (N,)."""

    displacement: Array
    error: Array
    block: NDArray[np.int64]


def learn(used: Sequence[Simulated], others: Sequence[Simulated], values: Mapping[str, float]) -> Learned:
    """Learn the correction of a fitted model.

    Args:
        used: simulations of the recordings that were fitted to. others: those of the recordings held out.
        values: of all parameters, as fitted.

    Raises:
        SimulationError: a recording that has no solution with these values.
    """
    parts = [_rows(one, values) for one in used]
    firsts = np.concatenate(([0], np.cumsum([int(one.block[-1]) + 1 for one in parts])))
    displacement, error = (np.concatenate([getattr(one, name) for one in parts]) for name in ("displacement", "error"))
    block = np.concatenate([one.block + first for one, first in zip(parts, firsts, strict=False)])
    test = block % EVERY == EVERY // 2
    if not test.any() or test.all():
        return Learned(None, np.nan, np.nan)
    tried = train(displacement, error, block, ~test)
    before, after = _rms(error[test]), _rms((error - along(tried, displacement))[test])
    if after > (1.0 - GAIN) * before:
        return Learned(None, before, after)
    residual = train(displacement, error, block, np.ones(len(block), dtype=np.bool_))
    held_out = []
    for one in others:
        rows = _rows(one, values)
        left = rows.error - along(residual, rows.displacement)
        held_out.append((one.recording.name, _rms(rows.error), _rms(left)))
    return Learned(residual, before, after, tuple(held_out))


def _rows(simulation: Simulated, values: Mapping[str, float]) -> _Rows:
    """Return the commands when the tip was where a pose shows it, and the model's errors there."""
    recording = simulation.recording
    error = recording.position - simulation.predicted_poses(simulation.motion(values), values["delay"])
    times = recording.pose_times - values["delay"] - values["lag"]
    now = np.clip(np.searchsorted(recording.times, times, side="right") - 1, 0, None)
    keep = np.arange(len(times)) % max(1, len(times) // ROWS) == 0
    armed = keep & recording.armed[now]
    if not armed.any():
        armed = keep
    block = np.unique(np.floor(times[armed] / BLOCK), return_inverse=True)[1]
    return _Rows(recording.command[now][armed], error[armed], block.astype(np.int64))


def _rms(error: Array) -> float:
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))
