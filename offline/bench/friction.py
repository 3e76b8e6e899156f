"""Effects of tendon friction: a slow pull and release of one tendon, and the laws on profile `rig` with friction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.lockstep import open_loop
from tendond.model.rods.selection import Solver
from tendond.offline.bench.profiles import LAWS, ProfileRow, profile_config, run_profile
from tendond.schemas.assumed_rig import TENDON_STIFFNESS
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import TendonCommand

Array = NDArray[np.float64]

COEFFICIENTS = (0.0, 0.05, 0.1, 0.2)
FARTHEST = 0.058
"""Travel of the paper's tendon [m]."""

HALFWAY = 0.02
"""Travel at which the tip's x goes fastest with it [m]."""

STEPS = 600
"""Steps in each direction: a minute, practically at rest."""

PERIOD = 0.1
SLACK = (-0.1, -0.1, -0.1)
"""Displacement of the other tendons [m]."""

HEADING = (
    "| coefficient | law | servo pulls at 58 mm [N] | rod is pulled [N] | lost at the reversal [mm] | x at 20 mm,"
    " pulled and paid out [mm] | settled [s] | error [mm] |\n| --- | --- | --- | --- | --- | --- | --- | --- |"
)


@dataclass(frozen=True)
class FrictionLoop:
    """A slow pull of tendon 0 to `FARTHEST` and back, of a rod without weight; each of shape (2 STEPS,).

    Attributes:
        end: displacement of the servo's end [m].
        before, behind: tension at the servo, and as the rod feels it [N].
        x: tip x [m].
    """

    end: Array
    before: Array
    behind: Array
    x: Array

    @property
    def lost(self) -> float:
        """Difference of the end between pulling and paying out at the same x, near the reversal [m]."""
        back = np.flatnonzero((np.arange(len(self.end)) >= STEPS) & (self.end > 0.8 * FARTHEST))
        pulled = 0.95 * FARTHEST
        x = float(np.interp(pulled, self.end[:STEPS], self.x[:STEPS]))
        return pulled - float(np.interp(x, self.x[back], self.end[back]))


def pull_and_release(
    coefficient: float, stiffness: float = TENDON_STIFFNESS, solver: Solver = "shooting"
) -> FrictionLoop:
    """Pull and release a tendon of `stiffness` [N/m] with a friction coefficient [-], on the rod of a solver.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    config = check_config(
        {
            "simulator": {
                "drive": "displacement",
                "period": PERIOD,
                "servo": {"friction": coefficient},
                "solver": solver,
                "rod": {"tendon_stiffness": stiffness, "gravity": [0.0, 0.0, 0.0]},
            }
        },
        "friction",
    )
    tensions = (0.0,) * len(config.simulator.rod.tendon_positions)
    ends = np.concatenate([np.linspace(0.0, FARTHEST, STEPS), np.linspace(FARTHEST, 0.0, STEPS)]).tolist()
    commands = (
        TendonCommand(seq=0, stamp_ns=0, pose_seq=None, displacement=(end, *SLACK), tension=tensions, armed=True)
        for end in ends
    )
    rows = [
        (end, state.tension[0], truth.tension[0], truth.position[0])
        for end, (state, truth) in zip(ends, open_loop(config, commands), strict=True)
    ]
    return FrictionLoop(*np.array(rows).T)


def run_rig(law: str, coefficient: float) -> ProfileRow:
    """Profile `rig` with tendons that rub.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    config = profile_config("rig", law)
    servo = config.simulator.servo.model_copy(update={"friction": coefficient})
    simulator = config.simulator.model_copy(update={"servo": servo})
    return run_profile("rig", law, config.model_copy(update={"simulator": simulator}))


def table() -> str:
    """Run some coefficients with both laws, and write the Markdown table."""
    lines = [HEADING]
    for coefficient in COEFFICIENTS:
        loop = pull_and_release(coefficient)
        pulled = float(np.interp(HALFWAY, loop.end[:STEPS], loop.x[:STEPS]))
        paid_out = float(np.interp(HALFWAY, loop.end[: STEPS - 1 : -1], loop.x[: STEPS - 1 : -1]))
        for law in LAWS:
            row = run_rig(law, coefficient)
            settled = f"never: {row.fault}" if row.settled is None else f"{row.settled:.2f}"
            cells = (
                f"{coefficient:g}", law, f"{loop.before[STEPS - 1]:.1f}", f"{loop.behind[STEPS - 1]:.1f}",
                f"{1e3 * loop.lost:.2f}", f"{1e3 * pulled:.1f}, {1e3 * paid_out:.1f}", settled, f"{row.error_mm:.2f}",
            )  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
