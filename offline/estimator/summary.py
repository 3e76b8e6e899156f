"""What the runs of each case come to, beside the goals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.estimator.fixed_gain import FACTORS, OFFSETS
from tendond.offline.estimator.runs import PERIOD, REST, Case, Run

Array = NDArray[np.float64]

CASES = (
    Case("free motion"),
    Case("the same, mass on the tip among the parameters", weighed=True),
    Case("unknown mass on the tip", mass=0.2),
    Case("the same, among the parameters", mass=0.2, weighed=True),
    Case("load on the tip", load=2.0),
    Case("load, three markers and no pose", pose=False, markers=(1 / 3, 2 / 3, 1.0), load=2.0),
    Case(
        "markers lost, swapped, gaps of 0.1 s",
        pose=False,
        markers=(1 / 3, 2 / 3, 1.0),
        load=1.0,
        load_time=3.45,
        gap=0.1,
        lost=0.2,
        swapped=True,
    ),
)
"""All measure with a camera's noise; the pose is the tip's, with orientation."""

CHI_SQUARE = 7.815
"""Square within which 95 % of errors of three numbers lie, in units of their spread."""

FOUND_AFTER, FOUND_UNTIL = 0.3, 0.5
"""Time after which a load is to be known, and until which it is averaged [s]."""

RATIO, SHAPE_FREE, SHAPE_LOAD, FORCE, COVERED, LOST = 0.7, 0.005, 0.01, 0.05, (0.92, 0.98), 0.02
"""Goals: error of the tip, of the best fixed-gain observer's; of the shape in free motion, and with an unknown load, in
the length; of a load's size; share of errors within their ellipsoid of 95 %; largest error of the shape with faults."""


@dataclass(frozen=True)
class Summary:
    """Runs of one case; lengths in the robot's length.

    Attributes:
        case: of these. runs: number of them.
        tip: RMS error of the tip. fixed: that of the best observer of fixed gains, and its name; none without a pose.
        shape, shape_worst: RMS error along the backbone, of all runs and the largest of a cycle.
        covered: share of the tip's errors within their ellipsoids of 95 %; force_covered: of the force's.
        force: median error of a load beside its size; none without one.
        stiffness, mass: RMS error of the stiffness and of the mass on the tip [kg] at the end.
        consistency: mean at the end.
    """

    case: Case
    runs: int
    tip: float
    fixed: tuple[float, str] | None
    shape: float
    shape_worst: float
    covered: float
    force_covered: float
    force: float | None
    stiffness: float
    mass: float
    consistency: float

    @property
    def missed(self) -> list[str]:
        """Goals that are missed."""
        faults = self.case.gap > 0.0
        wrong: list[str] = []
        if self.case.mass and not self.case.weighed:  # is for comparison
            return wrong
        if self.fixed is not None and self.tip > RATIO * self.fixed[0]:
            wrong.append(f"tip {self.tip / self.fixed[0]:.2f} of {self.fixed[1]}'s, goal {RATIO:g}")
        allowed = SHAPE_LOAD if self.case.load else SHAPE_FREE
        if self.shape > allowed:
            wrong.append(f"shape {100 * self.shape:.2f} % of L, goal {100 * allowed:g}")
        if faults and self.shape_worst > LOST:
            wrong.append(f"shape at worst {100 * self.shape_worst:.1f} % of L, goal {100 * LOST:g}")
        if self.force is not None and not faults and self.case.pose and self.force > FORCE:
            wrong.append(f"force {100 * self.force:.1f} %, goal {100 * FORCE:g}")
        if not faults and not COVERED[0] <= self.covered <= COVERED[1]:
            wrong.append(
                f"{100 * self.covered:.1f} % within ellipsoids, goal {100 * COVERED[0]:g} to {100 * COVERED[1]:g}"
            )
        return wrong


def summarise(case: Case, runs: Sequence[Run], length: float) -> Summary:
    """Return what the runs of a case come to; `length`: of the robot [m]."""
    first = round(REST / PERIOD)
    shape = np.array([run.shape[first:] for run in runs]) / length
    return Summary(
        case=case,
        runs=len(runs),
        tip=_rms(np.array([run.tip[first:] for run in runs])) / length,
        fixed=_best_fixed(runs, first, length) if case.pose else None,
        shape=_rms(shape),
        shape_worst=float(shape.max()),
        covered=float(np.mean([run.tip_square[first:] < CHI_SQUARE for run in runs])),
        force_covered=float(np.mean([run.force_square[first:] < CHI_SQUARE for run in runs])),
        force=_force_error(case, runs) if case.load else None,
        stiffness=_rms(np.array([run.stiffness[-1] for run in runs])),
        mass=_rms(np.array([run.mass[-1] for run in runs])),
        consistency=float(np.mean([run.consistency[-1] for run in runs])),
    )


def _best_fixed(runs: Sequence[Run], first: int, length: float) -> tuple[float, str]:
    """Error and name of the fixed-gain observer that is best over all runs."""
    names = [f"force x {one:g}" for one in FACTORS] + [f"offset {one:g}" for one in OFFSETS]
    errors = np.sqrt(np.mean(np.array([run.fixed[first:] for run in runs]) ** 2, axis=(0, 1)))
    best = int(np.argmin(errors))
    return float(errors[best]) / length, names[best]


def _force_error(case: Case, runs: Sequence[Run]) -> float:
    """Median over the runs of the error of a load beside its size, once it is to be known."""
    part = slice(round((case.load_time + FOUND_AFTER) / PERIOD), round((case.load_time + FOUND_UNTIL) / PERIOD))
    return float(np.median([np.mean(run.force[part]) / np.linalg.norm(run.load[-1]) for run in runs]))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


HEADING = (
    "| case | runs | tip [mm] | best fixed gains [mm] | shape [% L] | worst [% L] | tip in 95 % | force in 95 % | load"
    " | stiffness | mass [g] | consistency | |\n" + 13 * "| --- " + "|"
)


def markdown(summaries: Sequence[Summary], length: float) -> str:
    """Write the table; `length`: of the robot [m]."""
    return "\n".join([HEADING, *(_row(one, length) for one in summaries)])


def _row(one: Summary, length: float) -> str:
    fixed = "-" if one.fixed is None else f"{1e3 * one.fixed[0] * length:.3f} ({one.fixed[1]})"
    cells = (
        one.case.name,
        f"{one.runs}",
        f"{1e3 * one.tip * length:.3f}",
        fixed,
        f"{100 * one.shape:.3f}",
        f"{100 * one.shape_worst:.2f}",
        f"{100 * one.covered:.1f} %",
        f"{100 * one.force_covered:.1f} %",
        "-" if one.force is None else f"{100 * one.force:.1f} %",
        f"{100 * one.stiffness:.1f} %",
        f"{1e3 * one.mass:.2f}",
        f"{one.consistency:.2f}",
        "; ".join(one.missed) or "pass",
    )
    return f"| {' | '.join(cells)} |"
