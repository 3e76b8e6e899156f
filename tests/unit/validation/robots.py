"""A simulated robot for the tests of the validation: one section, three tendons, commands up and down again."""

import numpy as np
from numpy.typing import NDArray

from tendond.offline.validation.datasets.poses import Poses, held_out_blocks
from tendond.offline.validation.rods.build import build
from tendond.offline.validation.rods.known import straight
from tendond.offline.validation.rods.parameters import defaults, parameters_of
from tendond.offline.validation.rods.predict import predict

Array = NDArray[np.float64]

DESIGN = straight(3, 0.2, 0.008, (0.0, 0.0, 0.0))
TRUE = {"length_0": 0.206, "radius": 0.0072, "base_x": 0.004, "base_turn_y": 0.05, "zero_1": 5e-4}


def sweeps(rounds: int = 4, points: int = 5, most: float = 6e-3) -> Array:
    """Return commands [m] that pull one tendon after the other and release it, shape (rounds * 3 * 2 * points, 3)."""
    up = np.linspace(0.0, most, points)
    rows = []
    for turn in range(rounds):
        for tendon in range(3):
            for value in (*up, *up[::-1]):
                row = np.full(3, -2e-3)
                row[tendon] = value * (1.0 - 0.1 * turn)
                rows.append(row)
    return np.array(rows)


def values_of(**changed: float) -> dict[str, float]:
    """Return the values of all parameters, some of them changed."""
    return {**defaults(parameters_of(DESIGN)), **changed}


def simulated(noise: float = 0.0, **more: float) -> Poses:
    """Return poses of a robot with the parameters TRUE and `more`; noise of the tips [m], sigma an axis."""
    command = sweeps()
    tip = predict(build(DESIGN, values_of(**TRUE, **more)), command).tip
    tip = tip + noise * np.random.default_rng(7).standard_normal(tip.shape)
    block = np.arange(len(command)) // 6
    labels = tuple(f"block {i}" for i in range(int(block[-1]) + 1))
    return Poses("simulated", "this test", command, tip, block, labels, held_out_blocks(block))
