"""The edge of stability: a condition under which both rows of the paper's table come out."""

from collections.abc import Mapping
from typing import Any

from tendond.schemas.config.robot import RodSection
from tendond.schemas.paper_robot import TARGET_X

Tables = dict[str, Any]

PAPERS_Z: Tables = {"reference": {"position": [TARGET_X, 0.0, 0.0], "unreachable": "track", "path": "direct"}}
"""The target as the paper writes it, which the rod cannot rest at."""

EDGE: dict[str, float] = {
    "youngs_modulus": 1.035,
    "density": 1.42,
    "bending_damping": 0.89,
    "tension_max": 87.5,
    "pretension": 1.42,
}
"""The edge of stability: the first three are the controller's model as a multiple of the plant, then [N], [N].

Beside these, `edge_tables` gives both laws the measured velocity, a pair of tendons and the target as the paper writes
it. The five numbers were found by a search (differential evolution) for a condition under which both rows of the paper
come out; they are one such condition, not a measurement of the paper's.
"""

EDGE_NEIGHBOURS: dict[str, dict[str, float]] = {
    f"{name} {factor:g}": {**EDGE, name: EDGE[name] * factor} for name in EDGE for factor in (0.98, 1.02)
}
"""One number of `EDGE` at a time, ±2 %: the edge's sensitivity."""


def edge_tables(edge: Mapping[str, float] = EDGE) -> Tables:
    """Return the configuration of `EDGE`: model, feedback and limits of the controller."""
    plant = RodSection()
    return {
        "rod": {
            "youngs_modulus": edge["youngs_modulus"] * plant.youngs_modulus,
            "density": edge["density"] * plant.density,
            "bending_damping": [edge["bending_damping"] * value for value in plant.bending_damping],
        },
        "simulator": {
            "rod": {name: getattr(plant, name) for name in ("youngs_modulus", "density", "bending_damping")},
        },
        "control": {"feedback": "direct", "antagonist": 2},
        "limits": {"tension_max": edge["tension_max"]},
        "pretension": {"tension": edge["pretension"]},
        **PAPERS_Z,
    }
