"""Control laws, each a file of its own; further ones may be in any installed package, see `registry`."""

from tendond.daemon.control.laws.law import (
    Convergence,
    Decision,
    Law,
    LawParameters,
    LawTerms,
    PlanarObservation,
    SpatialObservation,
    StatefulLaw,
    StatelessLaw,
)
from tendond.daemon.control.laws.registry import LAWS, select_law
from tendond.daemon.control.tasks.plane import BENDING_PLANE
from tendond.daemon.control.tasks.space import SPACE

__all__ = [
    "BENDING_PLANE",
    "LAWS",
    "SPACE",
    "Convergence",
    "Decision",
    "Law",
    "LawParameters",
    "LawTerms",
    "PlanarObservation",
    "SpatialObservation",
    "StatefulLaw",
    "StatelessLaw",
    "select_law",
]
