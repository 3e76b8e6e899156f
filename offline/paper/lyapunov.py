"""Rises of a law's Lyapunov function in a run, and their causes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.laws import select_law
from tendond.daemon.control.reference.planar import PLANES
from tendond.offline.paper.run import PaperRun

Array = NDArray[np.float64]

AT_REST = 1e-7
"""Fraction of V's maximum below which V is what rank 1 and the solver's tolerance leave, and its rises mean nothing."""

FALLEN = 1e-4
"""Fraction of V's maximum down to which its rate is measured."""

CAUSES = {
    "limit": "a limit held the command back",
    "rank": "along the rod's axis at the tip, where b_c does not reach (rank 1)",
    "sampled": "within reach of b_c: a command is held for a whole cycle, and the inputs of the law may be wrong",
    "rest": f"at rest: V below {AT_REST:.0e} of its greatest value",
}


@dataclass(frozen=True)
class Rises:
    """Iterations i with V(i+1) > V(i), by cause; `falls` counts the others."""

    limit: NDArray[np.intp]
    rank: NDArray[np.intp]
    sampled: NDArray[np.intp]
    rest: NDArray[np.intp]
    falls: int

    def of(self, cause: str) -> NDArray[np.intp]:
        """Iterations of one of `CAUSES`."""
        return np.asarray(getattr(self, cause))


def find_rises(run: PaperRun) -> Rises:
    """Sort the rises of V by cause.

    The change of V over a cycle is that of its squares along the tip's axis plus that across it, which is the one
    direction that b_c reaches; the greater of the two names the cause.
    """
    value = run.lyapunov
    change_along, change_across = (_change(run.errors, direction) for direction in _directions(run))
    rises = np.diff(value) > 0.0
    rest = rises & (value[:-1] < AT_REST * np.nanmax(value))
    limit = rises & ~rest & run.limited[:-1]
    left = rises & ~rest & ~limit
    rank = left & (change_along >= change_across)
    return Rises(
        limit=np.flatnonzero(limit),
        rank=np.flatnonzero(rank),
        sampled=np.flatnonzero(left & ~rank),
        rest=np.flatnonzero(rest),
        falls=int(np.sum(~rises)),
    )


def along_share(run: PaperRun) -> float:
    """Part of the last V that lies along the tip's axis, where b_c does not reach [-]."""
    along, _ = _directions(run)
    last = run.errors[-1]
    return float(np.sum((last @ along[-1]) ** 2) / np.sum(last**2))


def rate_of(run: PaperRun) -> float:
    """Rate at which V falls in theory [1/s]: V' = -2 rate V, with epsilon and the smaller of the terms left out.

    Backstepping: V' = -alpha1 z1'z1 - alpha2 z2'z2 with z2 = -alpha1 z1 + velocity error, which outweighs z1 by
    alpha1 squared. Sliding mode: V' = -k S'S.
    """
    control = run.scenario.config.control
    parameters = select_law(control.law, control.laws)[1].model_dump()
    return float(parameters["alpha2" if run.law == "backstepping" else "k"])


def measured_rate(run: PaperRun) -> float:
    """Rate at which V falls from its greatest value until it stays below `FALLEN` of it [1/s]; NaN if it does not."""
    value = run.lyapunov
    top = int(np.nanargmax(value))
    passed = int(np.flatnonzero(value[top:] >= FALLEN * value[top])[-1]) + 1
    if top + passed >= len(value):
        return float("nan")
    fallen = float(np.log(value[top] / value[top + passed]))
    return fallen / (passed * run.scenario.config.loop.period)


def _directions(run: PaperRun) -> tuple[Array, Array]:
    """Unit vectors in the plane along the tip's axis and across it, each of shape (k, 2)."""
    ends = run.shapes[:, -3:][:, :, list(PLANES[run.scenario.config.control.plane])]
    along = 1.5 * ends[:, 2] - 2.0 * ends[:, 1] + 0.5 * ends[:, 0]  # derivative at the end of the last three points
    along /= np.linalg.norm(along, axis=1)[:, None]
    return along, np.stack([along[:, 1], -along[:, 0]], axis=1)


def _change(errors: Array, direction: Array) -> Array:
    """Change of half the squares along the direction at the start of each cycle, shape (k-1,)."""
    before = np.einsum("kmi,ki->km", errors[:-1], direction[:-1])
    after = np.einsum("kmi,ki->km", errors[1:], direction[:-1])
    return np.asarray(0.5 * (after**2 - before**2).sum(axis=1))
