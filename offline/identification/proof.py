"""The proof: simulated rigs whose parameters are known, identified from logs of the real controller.

The simulated rod is not the fitted one in another dress: it is solved with another scheme along the rod (Runge-Kutta of
fourth order, 15 nodes against six of sixth order), another one in time (BDF2 at 0.5 ms against nearly the trapezoidal
rule at 5 and 2.5 ms), and its servos have a smallest step, of which the fit knows nothing. The controller that makes
the logs has the paper's parameters, all of which are wrong, and its commands answer to the noise. One rig carries a
tool that the controller is not configured for: a ball with inertia, where the fit has a point mass.
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.rod.tip_body import ball_inertia
from tendond.offline.identification.data import WEIGHT_NOTE, Recording, load_recording
from tendond.offline.identification.dry_run import dry_run
from tendond.offline.identification.fit import FitProblem, Memory, refine
from tendond.offline.identification.identify import Identification, Options, identify
from tendond.offline.identification.parameters import DEFAULT, chosen
from tendond.offline.identification.plan import propose
from tendond.offline.identification.simulate import Simulation
from tendond.offline.identification.statistics import statistics
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.paper_robot import YOUNGS_MODULUS

Array = NDArray[np.float64]

LATENCY, NOISE, LAG, BACKLASH, WEIGHT = 0.01, 1e-4, 0.025, 6.5e-5, 0.05
PERIOD, FINE_PERIOD = 0.0005, 0.0001
"""[s] Of the simulated rod; the finer one for the study of errors, which a plant's own time step must not enter: where
the torque goes off, half a step of it is found as delay and drag (of 0.2 ms as a third of a standard error)."""

CONTROLLER: dict[str, Any] = {
    "rod": {"tendon_stiffness": 2e4},
    "limits": {
        "tension_max": 60.0, "displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": 0.085,
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
"""Of Young's modulus: the ends of `tendond study robustness`' axis, and one between."""

TIP_MASS = {"soft": 0.0, "stiff": 0.0, "tool": 0.03}
"""[kg] Of a body on the tip, unknown to the controller and in every log."""

GOALS = {"E": 0.02, "rho": 0.03, "Bbt": 0.10, "C": 0.20, "tip_mass": 0.0009, "delay": 0.002}
"""What the values may be off: those of `ABSOLUTE` in their units, the others as a part."""

ABSOLUTE = ("tip_mass", "delay")
"""Parameters that may be zero: 3 % of 30 g, and seconds."""

LOGS: dict[str, tuple[tuple[str, ...], float, float]] = {
    "free": (("sway", "chirp"), 1.0, 0.0),
    "weighted": (("steps",), 0.6, WEIGHT),
    "held-out": (("steps",), 0.8, 0.0),
}
"""Parts of the plan, reach, weight [kg]; the last one is not fitted to."""

USED = ("free", "weighted")


@dataclass(frozen=True)
class ProofTask:
    """One rig to identify.

    Attributes:
        plant: of `FACTORS`. seed: of its noise. folder: for its logs. noise: of the poses [m].
    """

    plant: str
    seed: int
    folder: str
    noise: float = NOISE


@dataclass(frozen=True)
class ProofOutcome:
    """What an identification came to, small enough to travel between processes.

    Attributes:
        task: that it is of.
        values, errors: of the parameters that were found, by name, and their standard errors.
        missing: names that were not found.
        seconds: of the logs that were fitted to.
        held_out: distance of model and tip on the log held out, root mean square [m]: configuration's, identified.
    """

    task: ProofTask
    values: dict[str, float]
    errors: dict[str, float]
    missing: tuple[str, ...]
    seconds: float
    held_out: tuple[float, float] | None = None


def truth(plant: str) -> dict[str, float]:
    """The plant's parameters, by name."""
    return {
        "E": YOUNGS_MODULUS * FACTORS[plant],
        "rho": BUILT["density"],
        "Bbt": BUILT["bending_damping"][0],
        "C": BUILT["drag"][0],
        "tendon_stiffness": BUILT["tendon_stiffness"],
        "tip_mass": TIP_MASS[plant],
        "delay": LATENCY,
        "lag": LAG,
        "backlash": BACKLASH,
        "spool": 1.0,
    }


def unknowns() -> list[tuple[str, list[str]]]:
    """What the controller does not know, in words, and the plants of which that holds."""
    bare = [plant for plant in FACTORS if TIP_MASS[plant] == 0.0]
    shown = "a tool that is not configured, E off by 10 %"
    return [("E off by 15 %", bare), (shown, [plant for plant in FACTORS if plant not in bare])]


def rig(plant: str, seed: int, weight: float, noise: float = NOISE) -> RigConfig:
    """Controller and simulated plant."""
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
        "servo": {"lag": LAG, "backlash": BACKLASH, "resolution": 2.3e-5},
        "mocap": {"period": 0.01, "noise": noise, "latency": LATENCY},
    }
    return check_config({**CONTROLLER, "rig": {"name": f"proof-{plant}"}, "simulator": simulator}, "proof")


def record(task: ProofTask) -> dict[str, Path]:
    """The logs of a rig, by name; those that are there are made anew. Without noise they are for `redraw` alone."""
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


def identify_logs(paths: Mapping[str, Path], jobs: int) -> Identification:
    """The identification of a rig's logs."""
    recordings = {name: load_recording(path, {}) for name, path in paths.items()}
    used = [recordings[name] for name in USED]
    held = [recordings["held-out"]] if "held-out" in recordings else []
    return identify(used, held, Options(DEFAULT, jobs=jobs))


def prove(task: ProofTask) -> tuple[ProofOutcome, Identification]:
    """Record a rig's logs and identify it, in this process."""
    result = identify_logs(record(task), jobs=1)
    held = [recorded for recorded in result.held_out if not recorded.used]
    return ProofOutcome(
        task=task,
        values=result.values,
        errors={found.parameter.name: found.error for found in result.parameters if found.found},
        missing=tuple(found.parameter.name for found in result.parameters if not found.found),
        seconds=sum(simulation.recording.duration for simulation in result.simulations),
        held_out=(held[0].nominal_rms, held[0].fitted_rms) if held else None,
    ), result


def redraw(task: ProofTask) -> ProofOutcome:
    """Identify a rig again from logs without noise, that of the task's seed added to the poses.

    The derivatives are those at the truth, taken once, and the fit starts there: what is asked is how it scatters.
    """
    recordings, problem, jacobian = _at_truth(task.plant, task.folder)
    random = np.random.default_rng([task.seed, 7])
    simulations = []
    for recording in recordings:
        position = recording.position + NOISE * random.standard_normal(recording.position.shape)
        simulations.append(Simulation(replace(recording, position=position, noise=NOISE), "measured"))
    noisy = FitProblem(simulations, problem.parameters, problem.start, None, 1, lambda what, done, total: None)
    nothing = Memory(None, {})
    whole = refine(noisy, np.zeros(len(noisy.parameters)), jacobian, nothing, "linear", NOISE).coordinates
    result = refine(noisy.finer(), whole, jacobian, nothing, "linear", NOISE)
    deviations = statistics(result).deviations
    return ProofOutcome(
        task=task,
        values={parameter.name: result.values[parameter.name] for parameter in result.parameters},
        errors={
            parameter.name: parameter.error(result.values[parameter.name], float(deviation))
            for parameter, deviation in zip(result.parameters, deviations, strict=True)
        },
        missing=(),
        seconds=sum(recording.duration for recording in recordings),
    )


@functools.lru_cache(maxsize=1)
def _at_truth(plant: str, folder: str) -> tuple[list[Recording], FitProblem, Array]:
    """The logs without noise, the problem, and its derivatives at the truth."""
    recordings = [load_recording(Path(folder) / f"{name}.mcap", {}) for name in USED]
    simulations = [Simulation(recording, "measured") for recording in recordings]
    problem = FitProblem(
        simulations, chosen(DEFAULT), truth(plant) | {"zero": 0.0}, None, 1, lambda what, done, total: None
    )
    return recordings, problem, problem.jacobian(np.zeros(len(problem.parameters)))


def met(outcome: ProofOutcome) -> dict[str, bool]:
    """Which goals an outcome meets, by parameter."""
    true = truth(outcome.task.plant)
    return {
        name: name in outcome.values
        and abs(outcome.values[name] - true[name]) <= goal * (1.0 if name in ABSOLUTE else true[name])
        for name, goal in GOALS.items()
    }


def coverage(outcomes: list[ProofOutcome]) -> dict[str, dict[str, float]]:
    """Over many seeds, by parameter: how often the truth lies within two standard errors, and how the errors compare.

    `spread` is the root mean square of (value - truth) / standard error: one, where the errors are honest. `bias` is
    the mean of the same. Lag and backlash are left out: the simulated servos' reports have no noise, so that these two
    come out the same in every fit.
    """
    found: dict[str, dict[str, float]] = {}
    everything: list[float] = []
    for name in DEFAULT:
        if name in ("lag", "backlash"):
            continue
        scaled = [
            (outcome.values[name] - truth(outcome.task.plant)[name]) / outcome.errors[name]
            for outcome in outcomes
            if name in outcome.values
        ]
        if scaled:
            found[name] = _honesty(scaled)
            everything += scaled
    found["all"] = _honesty(everything)
    return found


def _honesty(scaled: list[float]) -> dict[str, float]:
    count = len(scaled)
    return {
        "fits": count,
        "within_two": sum(abs(value) <= 2.0 for value in scaled) / count,
        "spread": (sum(value**2 for value in scaled) / count) ** 0.5,
        "bias": sum(scaled) / count,
    }
