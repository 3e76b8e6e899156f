"""Simulated rigs whose parameters are known, and their logs by the real controller.

The simulated rod differs from the fitted one: it is solved with another scheme along the rod (Runge-Kutta of fourth
order, 15 nodes against six of sixth order), another one in time (BDF2 at 0.5 ms against nearly the trapezoidal rule at
5 and 2.5 ms), and its servos have a resolution that the fit does not model. The controller that writes the logs has
the paper's parameters, all of which are wrong, and its commands react to the noise. One rig carries a tool that the
controller is not configured for: a ball with inertia, where the fit has a point mass.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.rod.tip_body import ball_inertia
from tendond.offline.identification.excitation.dry_run import dry_run
from tendond.offline.identification.excitation.plan import propose
from tendond.offline.identification.recordings.weights import WEIGHT_NOTE
from tendond.schemas.assumed_rig import (
    BACKLASH,
    POSE_DELAY,
    POSE_NOISE,
    RESOLUTION,
    SERVO_RATE,
    TENDON_STIFFNESS,
)
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.paper_robot import YOUNGS_MODULUS

Array = NDArray[np.float64]


LAG, WEIGHT = 0.025, 0.05


PERIOD, FINE_PERIOD = 0.0005, 0.0001
"""Time steps of the simulated rod [s]. The finer one is for the study of errors, which the plant's time step must not
affect: where the torque goes off, half a step appears as delay and drag (0.2 ms: a third of a standard error)."""


CONTROLLER: dict[str, Any] = {
    "rod": {"tendon_stiffness": TENDON_STIFFNESS},
    "limits": {
        "tension_max": 60.0, "displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": SERVO_RATE,
        "slack": 0.001,
    },
}  # fmt: skip
"""The paper's robot with the servos' real speed; it knows nothing of delay and lag."""


BUILT: dict[str, Any] = {
    "density": 18900.0,
    "bending_damping": (0.0062, 0.0062, 0.0062),
    "drag": (0.14, 0.14, 0.14),
    "tendon_stiffness": 1.6e4,
}
"""The rod as it was built, beside its Young's modulus: a tenth heavier than the paper's, less damped, more drag."""


FACTORS = {"soft": 0.85, "stiff": 1.15, "tool": 0.9}
"""Factors of Young's modulus: the ends of the axis of `tendond study robustness`, and one between."""


TIP_MASS = {"soft": 0.0, "stiff": 0.0, "tool": 0.03}
"""Mass of a body on the tip [kg], unknown to the controller and in every log."""


LOGS: dict[str, tuple[tuple[str, ...], float, float]] = {
    "free": (("sway", "chirp"), 1.0, 0.0),
    "weighted": (("steps",), 0.6, WEIGHT),
    "held-out": (("steps",), 0.8, 0.0),
}
"""Parts of the plan, reach and weight [kg]; the last one is not fitted to."""


USED = ("free", "weighted")


@dataclass(frozen=True)
class ProofTask:
    """A rig to identify.

    Attributes:
        plant: key of `FACTORS`. seed: seed of its noise. folder: folder for its logs. noise: noise of the poses [m].
    """

    plant: str
    seed: int
    folder: str
    noise: float = POSE_NOISE


def truth(plant: str) -> dict[str, float]:
    """Return the plant's parameters, by name."""
    return {
        "E": YOUNGS_MODULUS * FACTORS[plant],
        "rho": BUILT["density"],
        "Bbt": BUILT["bending_damping"][0],
        "C": BUILT["drag"][0],
        "tendon_stiffness": BUILT["tendon_stiffness"],
        "tip_mass": TIP_MASS[plant],
        "delay": POSE_DELAY,
        "lag": LAG,
        "backlash": BACKLASH,
        "spool": 1.0,
    }


def unknowns() -> list[tuple[str, list[str]]]:
    """List the controller's wrong beliefs, in words, with the plants that they apply to."""
    bare = [plant for plant in FACTORS if TIP_MASS[plant] == 0.0]
    shown = "a tool that is not configured, E off by 10 %"
    return [("E off by 15 %", bare), (shown, [plant for plant in FACTORS if plant not in bare])]


def rig(plant: str, seed: int, weight: float, noise: float = POSE_NOISE) -> RigConfig:
    """Return the configuration of controller and simulated plant."""
    rod = {
        **BUILT, "youngs_modulus": YOUNGS_MODULUS * FACTORS[plant], "space": "rk4", "nodes": 15, "alpha": 0.0,
        "tip_mass": TIP_MASS[plant], "tip_inertia": ball_inertia(TIP_MASS[plant]),
    }  # fmt: skip
    simulator = {
        "period": PERIOD if noise > 0.0 else FINE_PERIOD,
        "rod": rod,
        "drive": "displacement",
        "weight": {"mass": weight},
        "seed": seed,
        "servo": {"lag": LAG, "backlash": BACKLASH, "resolution": RESOLUTION},
        "mocap": {"period": 0.01, "noise": noise, "latency": POSE_DELAY},
    }
    return check_config({**CONTROLLER, "rig": {"name": f"proof-{plant}"}, "simulator": simulator}, "proof")


def record(task: ProofTask) -> dict[str, Path]:
    """Record the logs of a rig, by name, replacing existing ones. Without noise they are for `redraw` only."""
    folder = Path(task.folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = {}
    for index, (name, (kinds, reach, weight)) in enumerate(LOGS.items()):
        if task.noise == 0.0 and name not in USED:
            continue
        config = rig(task.plant, 10 * task.seed + index, weight, task.noise)
        paths[name] = folder / f"{name}.mcap"
        paths[name].unlink(missing_ok=True)
        dry_run(config, propose(config, kinds, reach), paths[name], {WEIGHT_NOTE: str(weight)})
    return paths
