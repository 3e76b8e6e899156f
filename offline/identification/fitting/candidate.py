"""Candidates of a selection: parameters that are taken together, their fits, and what became of each."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.fitting.solve import minimum
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.parameters import FROM
from tendond.offline.validation.fitting.selection import criterion, independent

Array = NDArray[np.float64]
ProblemOf = Callable[[Sequence[Parameter], Mapping[str, float]], FitProblem]
"""Makes the problem of some parameters, from start values of all."""

STRONG = 6.0
"""Decrease of the criterion from which a parameter is taken."""

ALIKE = 2.0
"""Difference of the criterion that is not worth a mention (Kass & Raftery)."""

ROUGH = 1e-4
"""Relative tolerance of a candidate's fit. Derived: the criterion of a thousand residuals is then right to 0.1."""

ORDER = (
    "base_rotation", "base_position", "zeros", "spool", "delay", "lag", "backlash", "E", "tip_mass", "rho",
    "tendon_stiffness", "Bbt", "C", "mu", "radius", "radii", "precurvature", "tip_offset",
)  # fmt: skip
"""Candidates by name: mounting and servos before the rod, what is common before what is rare."""


@dataclass(frozen=True)
class Candidate:
    """Parameters that are taken together."""

    name: str
    parameters: tuple[Parameter, ...]


@dataclass(frozen=True)
class Trial:
    """A candidate's outcome.

    Attributes:
        name: of it. change: of the criterion, when it was taken or last tried. taken: whether it was. why: reason.
    """

    name: str
    change: float
    taken: bool
    why: str


@dataclass(frozen=True)
class Fitted:
    """Candidates that are taken, values of all parameters, and the problem's residuals and derivatives there."""

    taken: tuple[Candidate, ...]
    values: dict[str, float]
    problem: FitProblem
    residuals: Array
    jacobian: Array

    def bic(self, count: float) -> float:
        """Return the criterion for so many independent residuals."""
        return criterion(self.problem.data(self.residuals), self.jacobian.shape[1], count)

    @property
    def rms(self) -> float:
        """Root mean square of the poses' residuals, a coordinate [m]."""
        poses = np.concatenate([blocks[0].ravel() for blocks in self.problem.shaped(self.residuals)])
        return float(np.sqrt(np.mean(poses**2)))

    @property
    def independent(self) -> float:
        """Number of independent residuals: of the poses, whose neighbours err alike, and in proportion of the rest."""
        poses = [blocks[0] for blocks in self.problem.shaped(self.residuals)]
        share = self.problem.data(self.residuals).size / sum(block.size for block in poses)
        return share * sum(independent(block.ravel()) for block in poses)


def fitted_at(taken: tuple[Candidate, ...], values: dict[str, float], problem_of: ProblemOf) -> Fitted:
    """Evaluate what is taken at values."""
    problem = problem_of([parameter for one in taken for parameter in one.parameters], values)
    here = np.zeros(len(problem.parameters))
    return Fitted(taken, values, problem, problem.residuals(here), problem.jacobian(here))


def fit_candidates(
    taken: tuple[Candidate, ...], values: Mapping[str, float], problem_of: ProblemOf, noise: float
) -> Fitted:
    """Fit what is taken, from values."""
    first = begun(values, taken)
    problem = problem_of([parameter for one in taken for parameter in one.parameters], first)
    found = minimum(problem, noise=noise, tolerance=ROUGH)
    return fitted_at(taken, problem.values(found.x), problem_of)


def begun(values: Mapping[str, float], taken: Sequence[Candidate]) -> dict[str, float]:
    """Return values of which those of what is taken are off bounds at which derivatives vanish."""
    floors = {parameter.name: FROM[parameter.name] for one in taken for parameter in one.parameters
              if parameter.name in FROM}  # fmt: skip
    return {**values, **{name: max(values[name], floor) for name, floor in floors.items()}}
