"""Every simulation of the paper as a configuration: the preset PAPER and what a scenario changes in it.

An iteration is a cycle since tracking began; a force 'at iteration 50' acts in the step that follows cycle 50.
"""

import tomllib
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendond.offline.paper.edge import EDGE_NEIGHBOURS, PAPERS_Z, edge_tables
from tendond.offline.paper.published import LAWS
from tendond.schemas.assumed_rig import RESOLUTION, TENDON_STIFFNESS
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.paper_robot import TARGET_X

Tables = dict[str, Any]

ARMED = 5
"""Tick at which the operator arms."""

ITERATIONS = 200
"""Iterations of a run. The paper does not say how long its runs were; a law that keeps swinging travels further in a
longer one."""

DISTURBED_AT = 50
DISTURBANCE = (10.0, 0.0, -10.0)
"""Force on the tip [N]."""

DISTURBANCE_CYCLES = 1
"""The paper gives no duration."""

WEIGHTS_G = (20, 50)
HUNG_AT = 60
"""Iteration at which a weight is hung on in the scenario that shows how it is found."""

STRING = 0.3
"""Length of the string on which the weight hangs in the experiment [m]; the paper does not give it."""

SEED = 2024
IMPACTS = 6
IMPACT_SIZE = (2.0, 8.0)
"""Range of an impact's force [N]."""

IMPACT_PLACE = (0.4, 1.0)
"""Range of an impact's place, as a part of the rod's length."""

IMPACT_GAP = (18, 36)
"""Iterations between two."""

IMPACT_CYCLES = (1, 3)

EXCHANGED: Tables = {
    "control": {"laws": {"backstepping": {"alpha1": 2100.0, "alpha2": 12.0}, "sliding_mode": {"c": 1500.0, "k": 12.5}}}
}
"""Each law with the other's gains: kp = 1 + alpha1 alpha2 or c k, kd = alpha1 + alpha2 or c + k."""

DIRECT: Tables = {"control": {"feedback": "direct"}}
CONVERGED: Tables = {
    "rod": {"space": "rk6", "nodes": None},
    "simulator": {"rod": {"space": "rk6", "nodes": None}},
    "reference": {"position": [TARGET_X, 0.0, 0.0475]},  # where a converged rod rests at this x
}
YIELDING: Tables = {"reference": {"position": None, "across": TARGET_X}}

RIG: Tables = {
    "rod": {"space": "rk6", "nodes": None, "tendon_stiffness": TENDON_STIFFNESS},
    "observer": {"delay": 0.01, "lag": 0.01},
    "limits": {"slack": 0.002},
    "reference": CONVERGED["reference"],
    "simulator": {
        "drive": "displacement",
        "seed": SEED,
        "rod": {
            "space": "rk6",
            "nodes": None,
            "tendon_stiffness": 0.9 * TENDON_STIFFNESS,
            "youngs_modulus": 1.05 * RodSection().youngs_modulus,
            "density": 1.03 * RodSection().density,
            "bending_damping": [1.1 * value for value in RodSection().bending_damping],
        },
        "servo": {"lag": 0.01, "backlash": 2e-4, "resolution": RESOLUTION},
        "mocap": {"latency": 0.01, "noise": 1e-4},
    },
}
"""A rig-like plant: elastic tendons pulled by lagging servos, late and noisy poses, a rod that is not the model's."""


@dataclass(frozen=True)
class Scenario:
    """A simulation to run.

    Attributes:
        name: the scenario's name, the same for both laws.
        title: title in tables and figures.
        law: the controller's law.
        config: configuration of controller and plant.
        iterations: cycles to run.
    """

    name: str
    title: str
    law: str
    config: RigConfig
    iterations: int = ITERATIONS

    @property
    def start(self) -> int:
        """Tick at which tracking begins."""
        return start_of(self.config)


def start_of(config: RigConfig) -> int:
    """Return the tick of iteration 0."""
    return ARMED + round(config.pretension.duration / config.loop.period)


def paper_scenarios() -> list[Scenario]:
    """List all scenarios, each with both laws in a row."""
    edge = edge_tables()
    disturbance = _impacts([(DISTURBED_AT, DISTURBANCE_CYCLES, DISTURBANCE, 1.0)])
    listed: list[tuple[str, str, tuple[Tables, ...], int]] = [
        ("normal", "same information", (), ITERATIONS),
        ("normal_edge", "edge of stability", (edge,), ITERATIONS),
        ("normal_edge_exchanged", "edge, gains exchanged", (edge, EXCHANGED), ITERATIONS),
        ("normal_direct", "measured velocity", (DIRECT,), ITERATIONS),
        ("normal_papers_z", "z target 0, as written", (PAPERS_Z,), ITERATIONS),
        ("normal_rk6", "converged scheme (rk6)", (CONVERGED,), ITERATIONS),
        ("rig_normal", "rig-like plant", (RIG,), ITERATIONS),
        ("rig_normal_direct", "rig-like plant, measured velocity", (RIG, DIRECT), ITERATIONS),
        ("disturbance", "10 N, -10 N at 50", (disturbance,), ITERATIONS),
        ("disturbance_edge", "10 N, -10 N at 50, edge", (edge, disturbance), ITERATIONS),
    ]
    for grams in WEIGHTS_G:
        still = {"simulator": {"weight": {"mass": grams / 1000.0}}}
        hung = {"simulator": {"weight": {"mass": grams / 1000.0, "time": _time_of(HUNG_AT)}}}
        swinging = {"simulator": {"weight": {"mass": grams / 1000.0, "string": STRING}}}
        listed += [
            (f"weight_{grams}g", f"{grams} g", (still,), ITERATIONS),
            (f"weight_{grams}g_yielding", f"{grams} g, target x alone", (YIELDING, still), ITERATIONS),
            (f"weight_{grams}g_edge", f"{grams} g, edge", (edge, still), ITERATIONS),
            (f"weight_{grams}g_found", f"{grams} g hung on at {HUNG_AT}", (YIELDING, hung), ITERATIONS),
            (f"rig_weight_{grams}g", f"{grams} g hanging", (RIG, swinging), ITERATIONS),
        ]
    for name, numbers in EDGE_NEIGHBOURS.items():
        listed.append((f"edge_near {name}", f"edge, {name}", (edge_tables(numbers),), ITERATIONS))
    random = random_impacts(SEED)
    last = max(iteration for iteration, *_ in random)
    listed.append(("rig_impacts", "random impacts", (RIG, _impacts(random)), max(ITERATIONS, last + 50)))
    return [
        Scenario(name, title, law, _config(name, law, changes), iterations)
        for name, title, changes, iterations in listed
        for law in LAWS
    ]


Push = tuple[int, int, tuple[float, float, float], float]
"""Iteration, cycles, force [N], place along the rod."""


def random_impacts(seed: int) -> list[Push]:
    """Impacts of random size, direction, place and time; the same seed, the same impacts."""
    random = np.random.default_rng(seed)
    pushes: list[Push] = []
    iteration = 30
    for _ in range(IMPACTS):
        iteration += int(random.integers(IMPACT_GAP[0], IMPACT_GAP[1], endpoint=True))
        direction = random.standard_normal(3)
        x, y, z = (random.uniform(*IMPACT_SIZE) * direction / np.linalg.norm(direction)).tolist()
        cycles = int(random.integers(IMPACT_CYCLES[0], IMPACT_CYCLES[1], endpoint=True))
        pushes.append((iteration, cycles, (x, y, z), float(random.uniform(*IMPACT_PLACE))))
    return pushes


def _impacts(pushes: list[Push]) -> Tables:
    config = RigConfig()
    start, period = start_of(config), config.loop.period
    return {
        "simulator": {
            "impacts": [
                {"time": (start + iteration) * period, "duration": cycles * period, "force": force, "place": place}
                for iteration, cycles, force, place in pushes
            ]
        }
    }


def _time_of(iteration: int) -> float:
    """Simulated time of an iteration [s]."""
    config = RigConfig()
    return (start_of(config) + iteration) * config.loop.period


SWINGS_BORNE: Tables = {"faults": {"swing": 10.0, "tension_swing": 10.0, "tracking_error": 10.0, "orientation": 3.1}}
"""Thresholds for runs at the edge of stability, where the arm swings on purpose: no fault ends these runs for it."""


def _config(name: str, law: str, changes: tuple[Tables, ...]) -> RigConfig:
    tables = _merged(tomllib.loads(PAPER), SWINGS_BORNE)
    for change in (*changes, {"control": {"law": law}}):
        tables = _merged(tables, change)
    return check_config(tables, f"scenario {name}")


def _merged(tables: Tables, change: Tables) -> Tables:
    """`tables` with `change` laid over them."""
    merged = dict(tables)
    for key, value in change.items():
        before = merged.get(key)
        merged[key] = _merged(before, value) if isinstance(before, dict) and isinstance(value, dict) else value
    return merged
