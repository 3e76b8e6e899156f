"""One validation: baselines and rod fitted on the training part, errors on the held-out part."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.residual import Residual
from tendond.offline.correction.learned import along, train
from tendond.offline.validation.baselines.constant_curvature import predict_arcs
from tendond.offline.validation.baselines.polynomial import fit_polynomial
from tendond.offline.validation.datasets.poses import DatasetError, Poses, thinned
from tendond.offline.validation.fitting.identifiable import Knowledge, inseparable, knowledge_of
from tendond.offline.validation.fitting.problem import Problem, groups_of, staged
from tendond.offline.validation.fitting.selection import Trial, select
from tendond.offline.validation.results.metrics import Errors, by_tendon, errors_of
from tendond.offline.validation.results.repeatability import Jump, Repeatability, jumps, repeatability
from tendond.offline.validation.rods.build import build
from tendond.offline.validation.rods.design import Design
from tendond.offline.validation.rods.parameters import BASIC, defaults, parameters_of
from tendond.offline.validation.rods.predict import predict

Array = NDArray[np.float64]
Progress = Callable[[str], None]

MEMORY = ("backlash", "friction", "yielding")
"""Groups that make a rod remember the sequence."""

JUMP = 2e-3
"""Change of the model's error between successive poses that counts as a jump of the robot or the camera [m]."""


@dataclass(frozen=True)
class Request:
    """Settings of a validation.

    Attributes:
        groups: of parameters, besides the basic ones; none: those that the data support.
        poses: that a fit goes through, about; turning points of the commands are always among them.
        near, apart: pairs of poses for the repeatability, see there.
        residual: whether a correction is trained as well.
    """

    groups: tuple[str, ...] | None
    poses: int
    near: float
    apart: int
    residual: bool = False


@dataclass(frozen=True)
class ModelResult:
    """A model's tips and errors.

    Attributes:
        name: of it. parameters: number of fitted ones. tip: [m], shape (N, 3). training, held_out: errors.
    """

    name: str
    parameters: int
    tip: Array
    training: Errors
    held_out: Errors


@dataclass(frozen=True)
class Validation:
    """Everything that a report says.

    Attributes:
        poses: all of them. fitted: number of training poses that the fits went through. models: the rod is `rod`.
        by_tendon: held-out errors of the rod where each tendon is the one pulled most.
        knowledge, inseparable: of the rod's parameters. trials: of the selection.
        scatter: repeatability by the memoryless rod's errors. jumps: of the robot or the camera.
        failed: poses without an equilibrium. values: of the rod's parameters, by name. correction: learned one.
    """

    poses: Poses
    fitted: int
    models: list[ModelResult]
    by_tendon: list[Errors]
    knowledge: list[Knowledge]
    inseparable: list[tuple[str, str, float]]
    trials: list[Trial]
    scatter: Repeatability
    jumps: list[Jump]
    failed: int
    values: dict[str, float]
    correction: Residual | None = field(default=None)

    def model(self, name: str) -> ModelResult:
        """Return a model by its name."""
        return next(one for one in self.models if one.name == name)


def evaluate(poses: Poses, design: Design, request: Request, progress: Progress = lambda text: None) -> Validation:
    """Fit the baselines and the rod, and compare them on the held-out part.

    Raises:
        DatasetError: a design with another number of tendons, or a group that it does not have.
    """
    if len(design.ends) != poses.tendons:
        raise DatasetError(f"{poses.name}: {poses.tendons} tendons, but the robot's description has {len(design.ends)}")
    unknown = [one for one in request.groups or () if one not in groups_of(design)]
    if unknown:
        raise DatasetError(f"no group of parameters '{unknown[0]}': choose among {', '.join(groups_of(design))}")
    remembers = request.groups is None or bool(set(request.groups) & set(MEMORY))
    few = thinned(poses, request.poses, remembers)
    base = {**defaults(parameters_of(design)), **design.start}
    models = []

    def add(name: str, count: int, tip: Array) -> None:
        hidden = poses.held_out
        errors = (errors_of(tip[part], poses.tip[part]) for part in (~hidden, hidden))
        models.append(ModelResult(name, count, tip, *errors))

    progress("constant curvature")
    placed, _, problem = staged(design, few, [("pose",)], {**base, **_stiff(design)}, predict_arcs)
    add("constant curvature", len(problem.parameters), predict_arcs(design, placed, poses.command))
    arcs, _, problem = staged(design, few, [(*BASIC, "tendon_stiffness")], placed, predict_arcs)
    add("constant curvature, fitted", len(problem.parameters), predict_arcs(design, arcs, poses.command))
    progress("polynomial")
    training = ~poses.held_out
    polynomial = fit_polynomial(poses.command[training], poses.tip[training], poses.block[training])
    add("polynomial", polynomial.coefficients.size, polynomial.predict(poses.command))

    begin = dict(base)
    if not design.start:
        begin.update((one.name, arcs[one.name]) for one in parameters_of(design) if one.group in BASIC)
    trials: list[Trial] = []
    groups = request.groups
    if groups is None:
        progress("selection of the parameters")
        _, _, problem, trials = select(Problem(design, few, BASIC, begin))
        groups = tuple(one for one in problem.groups if one not in BASIC)
    plain = tuple(one for one in groups if one not in MEMORY)
    progress("rod without friction")
    stages: list[tuple[str, ...]] = [(*BASIC, *plain)] if plain and design.start else [BASIC, (*BASIC, *plain)]
    values, solution, problem = staged(design, few, stages, begin)
    frictionless = predict(build(design, values), poses.command)
    add("rod without friction", len(problem.parameters), frictionless.tip)
    if plain != groups:
        progress("rod")
        memory = tuple(one for one in groups if one in MEMORY)
        values, solution, problem = staged(design, few, [(*BASIC, *memory), (*BASIC, *groups)], begin)
    found = predict(build(design, values), poses.command)
    add("rod", len(problem.parameters), found.tip)
    correction = None
    if request.residual:
        correction = train(poses.command, poses.tip - found.tip, poses.block, training)
        count = len(problem.parameters) + np.size(correction.coefficients)
        add("rod with correction", count, found.tip + along(correction, poses.command))
    hidden = poses.held_out
    scale = float(np.sqrt(np.mean(solution.residuals**2)))
    error = frictionless.tip - poses.tip
    return Validation(
        poses, int(np.count_nonzero(~few.held_out)), models,
        by_tendon(found.tip[hidden], poses.tip[hidden], poses.command[hidden]),
        knowledge_of(problem.parameters, solution, scale), inseparable(problem.parameters, solution), trials,
        repeatability(poses.command, error, request.near, request.apart),
        jumps(poses.command, found.tip - poses.tip, request.near, JUMP), found.failed, values, correction,
    )  # fmt: skip


def _stiff(design: Design) -> dict[str, float]:
    """Return tendons that hardly stretch, as constant curvature is mostly taken."""
    return {"tendon_stiffness": 100.0 * design.tendon_stiffness}
