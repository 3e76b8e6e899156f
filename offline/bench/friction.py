"""Effects of tendon friction: a slow pull and release of one tendon, and the laws on profile `rig` with friction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.lockstep import open_loop
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
    "| coefficient | law | servo pulls at 58 mm [N] | mean along the path [N] | x at 20 mm,"
    " pulled and paid out [mm] | settled [s] | error [mm] | error, configured [mm] |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- |"
)


@dataclass(frozen=True)
class FrictionLoop:
    """A slow pull of tendon 0 to `FARTHEST` and back, of a rod without weight; each of shape (2 STEPS,).

    Attributes:
        end: displacement of the servo's end [m].
        before, behind: tension at the servo, and its mean along the path [N].
        x: tip x [m].
    """

    end: Array
    before: Array
    behind: Array
    x: Array


def pull_and_release(coefficient: float, stiffness: float = TENDON_STIFFNESS) -> FrictionLoop:
    """Pull and release a tendon of `stiffness` [N/m] with a friction coefficient [-], on the general rod.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    config = check_config(
        {
            "simulator": {
                "drive": "displacement",
                "period": PERIOD,
                "servo": {"friction": coefficient},
                "solver": "general",
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


def run_rig(law: str, coefficient: float, configured: float = 0.0) -> ProfileRow:
    """Run profile `rig` with a coefficient of friction [-], and one that is configured in the controller's model.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    config = profile_config("rig", law)
    servo = config.simulator.servo.model_copy(update={"friction": coefficient})
    simulator = config.simulator.model_copy(update={"servo": servo})
    rod = config.rod.model_copy(update={"tendon_friction": configured})
    return run_profile("rig", law, config.model_copy(update={"simulator": simulator, "rod": rod}))


def table() -> str:
    """Run some coefficients with both laws, and write the Markdown table."""
    lines = [HEADING]
    for coefficient in COEFFICIENTS:
        loop = pull_and_release(coefficient)
        pulled = float(np.interp(HALFWAY, loop.end[:STEPS], loop.x[:STEPS]))
        paid_out = float(np.interp(HALFWAY, loop.end[: STEPS - 1 : -1], loop.x[: STEPS - 1 : -1]))
        for law in LAWS:
            row, known = run_rig(law, coefficient), run_rig(law, coefficient, coefficient)
            settled = f"never: {row.fault}" if row.settled is None else f"{row.settled:.2f}"
            cells = (
                f"{coefficient:g}", law, f"{loop.before[STEPS - 1]:.1f}", f"{loop.behind[STEPS - 1]:.1f}",
                f"{1e3 * pulled:.1f}, {1e3 * paid_out:.1f}", settled, f"{row.error_mm:.2f}",
                f"{known.error_mm:.2f}",
            )  # fmt: skip
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)
