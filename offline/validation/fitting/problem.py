"""The fit of a robot's parameters to the training part of a data set, as residuals of normal numbers."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.validation.datasets.poses import Poses
from tendond.offline.validation.fitting.fit import Solution, fit
from tendond.offline.validation.rods.build import build
from tendond.offline.validation.rods.design import Design
from tendond.offline.validation.rods.parameters import Parameter, parameters_of
from tendond.offline.validation.rods.predict import predict

Array = NDArray[np.float64]
Model = Callable[[Design, dict[str, float], Array], Array]
"""Tips [m], shape (N, 3), of a design with values of its parameters, for commands [m], shape (N, m)."""

SIGMA = 1e-3
"""Standard deviation of the tips that the priors are weighed against [m]: a model's error, not the camera's noise."""

BEGIN = {"yielding": 0.5, "friction": 0.1, "tip_weight": 0.1, "backlash": 1e-4}
"""Values from which a group starts whose parameter is 0 while it is not fitted."""


def rod_tips(design: Design, values: dict[str, float], command: Array) -> Array:
    """Return the tips of the general rod, see `predict`."""
    return predict(build(design, values), command).tip


@dataclass(frozen=True)
class Problem:
    """Parameters of some groups, unknown; the others have the values of `base`.

    Attributes:
        design: of the robot. poses: of which those not held out are fitted; the model goes through all of them.
        groups: that are fitted. base: values of all parameters. model: predicts tips.
    """

    design: Design
    poses: Poses
    groups: tuple[str, ...]
    base: dict[str, float]
    model: Model = rod_tips

    @property
    def parameters(self) -> list[Parameter]:
        """The unknown parameters."""
        return [one for one in parameters_of(self.design) if one.group in self.groups]

    def values(self, z: Array) -> dict[str, float]:
        """Return the values of all parameters, the unknown ones z sigmas off their priors' centres."""
        found = dict(self.base)
        found.update((one.name, one.value(float(at))) for one, at in zip(self.parameters, z, strict=True))
        return found

    def start(self) -> Array:
        """Return where a fit begins, in sigmas."""
        begin = {**self.base, **{name: self.base[name] or value for name, value in BEGIN.items()}}
        return np.array([one.sigmas(begin[one.name]) for one in self.parameters])

    def residuals(self, z: Array) -> Array:
        """Return errors of the training part in units of SIGMA, shape (3 N,)."""
        tips = self.model(self.design, self.values(z), self.poses.command)
        return np.asarray(((tips - self.poses.tip)[~self.poses.held_out] / SIGMA).reshape(-1))

    def solve(self) -> tuple[dict[str, float], Solution]:
        """Return the most probable values of all parameters, and the solution that they come from."""
        found = fit(self.residuals, self.start())
        return self.values(found.z), found


def groups_of(design: Design) -> list[str]:
    """Return the names of all groups of a design's parameters."""
    return list(dict.fromkeys(one.group for one in parameters_of(design)))


def staged(
    design: Design, poses: Poses, stages: Iterable[tuple[str, ...]], base: dict[str, float], model: Model = rod_tips
) -> tuple[dict[str, float], Solution, Problem]:
    """Fit more and more groups, each stage from the values of the one before; return the last one's."""
    values = dict(base)
    for groups in stages:
        problem = Problem(design, poses, groups, values, model)
        values, solution = problem.solve()
    return values, solution, problem
