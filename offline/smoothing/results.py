"""What a smoother has found of a log, as arrays with names and units, a row per cycle."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import DaemonError
from tendond.model.estimation.kalman.sensors import Markers
from tendond.offline.files import whole
from tendond.offline.logs.arrays import Arrays
from tendond.offline.logs.export import export
from tendond.offline.logs.log import LogFile
from tendond.offline.smoothing.passes import SmoothedStretch

Array = NDArray[np.float64]

POINTS = 10
"""Points of the backbone, evenly spaced, the last of them the tip."""

UNITS = {
    "tip": "m",
    "shape": "m",
    "force": "N",
    "tension": "N",
    "moment": "N m",
    "time": "s",
    "measured": "m",
    "mass": "kg",
}
"""Units by the last part of a name that is no number; the others have none."""


@dataclass(frozen=True)
class Known:
    """A quantity and its standard deviation at each instant, shape (K, r)."""

    value: Array
    deviation: Array


def known(stretch: SmoothedStretch) -> dict[str, Known]:
    """Return the smoothed quantities: shape, tip, force on the tip, and errors of the model."""
    errors, shape = stretch.model.estimator.errors, _shape(stretch)
    found = {f"shape.{i}": Known(shape.value[:, i], shape.deviation[:, i]) for i in range(POINTS)}
    found["tip"] = found.pop(f"shape.{POINTS - 1}")
    parts = {"force": errors.force, "error.tension": errors.tension, "error.moment": errors.bend}
    parts["error.stiffness"] = slice(errors.stiffness, errors.stiffness + 1)
    if errors.size > errors.tip_mass.start:
        parts["error.mass"] = errors.tip_mass
    spread = np.sqrt(np.maximum(np.einsum("kii->ki", stretch.found.covariance), 0.0))
    found |= {name: Known(stretch.path.errors[:, part], spread[:, part]) for name, part in parts.items()}
    model = stretch.model
    acting = [
        model.estimate(errors).acting(instant.tensions)
        for errors, instant in zip(stretch.path.errors, model.stretch.instants, strict=True)
    ]
    found["tension"] = Known(np.array(acting), found["error.tension"].deviation)
    return found


def _shape(stretch: SmoothedStretch) -> Known:
    """Return points of the backbone [m], shape (K, POINTS, 3)."""
    estimator = stretch.model.estimator
    rod, unmodelled = estimator.rod, estimator.noise.unmodelled
    at = rod.robot.length * np.arange(1, POINTS + 1) / POINTS
    points = Markers(at, np.zeros(3), np.zeros(3 * POINTS))
    values, deviations = [], []
    for state, covariance in zip(stretch.path.states, stretch.found.covariance, strict=True):
        expected = points.expect(rod, estimator.errors, state)
        variance = np.einsum("ri,ij,rj->r", expected.rows, covariance, expected.rows, optimize=True)
        values.append(expected.value)
        deviations.append(np.sqrt(np.maximum(variance, 0.0) + unmodelled**2))
    return Known(np.array(values).reshape(-1, POINTS, 3), np.array(deviations).reshape(-1, POINTS, 3))


def table(log: LogFile, found: Sequence[SmoothedStretch]) -> Arrays:
    """Return all stretches of a log as arrays; periods that the loop missed are left out.

    A standard deviation has the quantity's name with `deviation.` before it; what the filter knew, forward in time,
    has `forward.`. `time` is that of the robot, since the first cycle, with missed periods and the drive's dead time.
    """
    parts = [_columns(log, number, one) for number, one in enumerate(found)]
    arrays = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Arrays(log.path, log.config, log.metadata, arrays, {name: _unit(name) for name in arrays})


def _columns(log: LogFile, number: int, stretch: SmoothedStretch) -> dict[str, NDArray[np.generic]]:
    instants, forward = stretch.model.stretch.instants, stretch.forward
    rows = [i for i, one in enumerate(instants) if one.tick is not None]
    errors = stretch.model.estimator.errors
    found: dict[str, NDArray[np.generic]] = {
        "tick": np.array([one.tick for one in instants if one.tick is not None]),
        "stretch": np.full(len(rows), number),
        "time": np.array([instants[i].time for i in rows]) + log.config.observer.command_delay,
    }
    quantities = known(stretch)
    columns = {name: one.value for name, one in quantities.items()}
    columns |= {f"deviation.{name}": one.deviation for name, one in quantities.items()}
    columns |= {"forward.tip": forward.tip, "forward.deviation.tip": forward.tip_deviation}
    columns |= {"forward.force": forward.errors[:, errors.force], "forward.deviation.force": forward.force_deviation}
    for name, values in columns.items():
        found[name] = values[rows, 0] if values.shape[1] == 1 and name.endswith(("stiffness", "mass")) else values[rows]
    return found


def _unit(name: str) -> str:
    return next((UNITS[part] for part in reversed(name.split(".")) if part in UNITS), "")


def write_table(run: Arrays, out: Path) -> int:
    """Write a table: CSV or Parquet as `tendond log export` does, or an .npz of the arrays; return its columns.

    Raises:
        UsageError: the name of the file ends in none of these, or pyarrow is not installed.
        DaemonError: the file cannot be written.
    """
    if out.suffix != ".npz":
        return export(run, out)
    try:
        with whole(out) as draft:
            np.savez_compressed(draft, allow_pickle=False, **run.arrays, units=np.array(json.dumps(run.units)))
    except OSError as error:
        raise DaemonError(f"{out}: cannot be written: {error.strerror}; choose another file with --out") from error
    return len(run.arrays)
