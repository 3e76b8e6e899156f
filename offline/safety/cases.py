"""Runs of the campaign, drawn from their seed: robot, law, target, what stands before it, and how the plant differs."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.body import Body
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.robot import RodSection

Array = NDArray[np.float64]

ROBOTS: dict[str, dict[str, Any]] = {
    "paper": {},
    "paper, 5 % damping": {"damping_ratio": 0.05},
    "nitinol": {"preset": "nitinol"},
    "rucker-webster-2011": {"preset": "rucker-webster-2011"},
}
"""Tables of [rod] by the robot's name."""

LAWS = ("backstepping", "sliding_mode", "sensitivity", "mpc")
KINDS = ("sphere", "half_space", "tip_region", "strain")
TRAJECTORIES = ("exponential", "minimum_jerk", "step")

PERIOD = 0.01
"""Period of the cycle [s]."""

STIFFNESS, MASS, DAMPING, WEIGHT = 0.1, 0.1, 0.3, 0.1
"""Largest relative difference of stiffness, mass and damping of the plant, and largest mass on its tip that the model
does not know, of the robot's own [-]."""

NOISE, DELAYS = 2e-4, (0, 1, 2)
"""Noise of each coordinate of the pose, of the length [-]; delay of the poses in cycles, right within one of them."""

MARGIN, ERROR = 0.01, 0.02
"""Margin and declared position error, of the length [-]. Chosen."""

STIFFNESS_ERROR = 0.15
"""Declared error of stiffness and mass [-]: both together, to first order sqrt(0.1^2 + 0.1^2)."""


@dataclass(frozen=True)
class Case:
    """A run.

    Attributes:
        seed: of all that is drawn. robot, law, kind: keys of the tables above.
        config: with the filter; the plant is in [simulator].
    """

    seed: int
    robot: str
    law: str
    kind: str
    config: RigConfig


def drawn(seed: int, attempt: int = 0) -> Case:
    """Draw a run; another `attempt` draws another one, where the obstacle would be on the resting arm.

    Raises:
        TendondError: the robot has no such rest.
    """
    rng = np.random.default_rng((seed, attempt))
    robot, law, kind = (str(rng.choice(options)) for options in (list(ROBOTS), LAWS, KINDS))
    section = RodSection.model_validate(ROBOTS[robot])
    rod = GeneralRod(robot_from_section(section), PERIOD)
    rest = rod.solve_static(np.zeros(len(rod.robot.tendons)))
    arm = float(np.hypot(*section.tendon_positions[0]))
    stiffness, length = rod.parameters.bending_stiffness, rod.robot.length
    pull = float(rng.uniform(0.8, 1.6)) * stiffness / (arm * length)
    target = _pulled(rod, rest, pull)
    before = _pulled(rod, rest, float(rng.uniform(0.4, 0.85)) * pull)
    shield = _shield(rng, kind, rod, (rest, before, target), arm, length)
    mass = section.density * np.pi * section.radius**2 * section.length
    delay = int(rng.choice(DELAYS))
    believed = max(0, delay + int(rng.integers(-1, 2)))
    return Case(seed, robot, law, kind, check_config({
        "loop": {"period": PERIOD},
        "rod": ROBOTS[robot],
        "control": {"law": law, "solver": "general", "laws": {"mpc": {"avoid": bool(rng.integers(0, 2))}}},
        "limits": {"tension_max": 3.0 * pull},
        "pretension": {"tension": 0.02 * pull, "duration": 0.1, "antagonist": 0.0},
        "observer": {"delay": believed * PERIOD},
        "reference": {
            "position": target.position.tolist(), "kind": str(rng.choice(TRAJECTORIES)),
            "rate": float(rng.uniform(3.0, 20.0)), "unreachable": "track", "branch": "below_135",
        },
        "safety": {
            "margin": MARGIN * length, "position_error": ERROR * length, "stiffness_error": STIFFNESS_ERROR,
            "delay_error": PERIOD, **shield,
        },
        "simulator": {
            "period": PERIOD, "solver": "general", "seed": seed,
            "rod": {**ROBOTS[robot], "scale": {
                "stiffness": _about(rng, STIFFNESS), "mass": _about(rng, MASS), "damping": _about(rng, DAMPING),
            }},
            "weight": {"mass": float(rng.uniform(0.0, WEIGHT) * mass)},
            "mocap": {"latency": delay * PERIOD, "noise": NOISE * length},
        },
    }, f"seed {seed}"))  # fmt: skip


def _about(rng: np.random.Generator, part: float) -> float:
    return float(1.0 + rng.uniform(-part, part))


def _pulled(rod: GeneralRod, rest: GeneralState, pull: float) -> GeneralState:
    """Return the rest under a pull of the first tendon [N], by way of half of it."""
    tensions, found = np.zeros(len(rod.robot.tendons)), rest
    for part in (0.5, 1.0):
        tensions[0] = part * pull
        found = rod.solve_static(tensions, start=found)
    return found


def _shield(
    rng: np.random.Generator, kind: str, rod: GeneralRod, states: tuple[GeneralState, ...], arm: float, length: float
) -> dict[str, Any]:
    """Return keys of [safety] that stand between the states' second, which they just admit, and the third."""
    rest, before, target = states
    body = Body(rod, (float(rng.uniform(0.6, 0.95)),))
    index = 1 if kind == "tip_region" else int(rng.integers(0, 2))
    shape = body.shape(before.strain)
    place = shape.points[index]
    ahead = body.shape(target.strain).points[index] - body.shape(rest.strain).points[index]
    ahead /= float(np.linalg.norm(ahead))
    room = (MARGIN + ERROR) * length
    if kind == "strain":
        return {"strain_max": (1.0 + STIFFNESS_ERROR + MARGIN) * float(np.max(np.linalg.norm(shape.bends, axis=1)))}
    if kind == "tip_region":
        side = {"kind": "half_space", "point": (place + room * ahead).tolist(), "normal": (-ahead).tolist()}
        return {"tip_region": side}
    if kind == "half_space":
        side = {"kind": kind, "point": (place + (room + arm) * ahead).tolist(), "normal": (-ahead).tolist()}
        return {"obstacle": [side]}
    radius = float(rng.uniform(0.05, 0.25)) * length
    center = place + (radius + room + arm) * ahead
    return {"obstacle": [{"kind": "sphere", "center": center.tolist(), "radius": radius}]}
