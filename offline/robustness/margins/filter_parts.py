"""Parts of the loop with the filter, each linear about a rest of the arm.

The plant's step has the rod's exact derivatives; the model's, with what the filter knows of its inputs, and the law's
are the controller's own functions, differenced. The filter's gain is that of its steady state, by its own transition.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.tasks.space import SpatialTask
from tendond.model.errors import ParameterError
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.robot import Body
from tendond.offline.robustness.margins.filter_law import differences, law_matrix

Array = NDArray[np.float64]

SETTLED = 10.0
"""Time of tracking after which the filter's gain is taken [s]."""

FAST = 0.9
"""Size from which on a pole that alternates from step to step is one of the fastest modes'."""

FINEST = 2.5e-3
"""Largest step of the plant [s]."""


@dataclass(frozen=True)
class PlantParts:
    """Plant over a cycle: x = (strains, rates).

    Attributes:
        step: by x, shape (2 n, 2 n). pull: by the tensions, (2 n, m). pose: of the tip by x, (6, 2 n).
        fast: poles of its fastest modes, which hardly move the tip, and which its scheme does not damp.
    """

    step: Array
    pull: Array
    pose: Array
    fast: Array


@dataclass(frozen=True)
class ModelParts:
    """Model, filter and law over a cycle, x as the plant's.

    The filter's causes are force, tension errors and moments; stiffness and tip mass are constants, and are left out.

    Attributes:
        period: of the cycle [s].
        step: by x, shape (2 n, 2 n). pull: by the tensions that act, (2 n, m).
        push: by force and moments, (2 n, 3 + b).
        pose: of the tip by x, (6, 2 n). decay: of the causes over a cycle, (3 + m + b,).
        gain: of strains, rates and causes, by the pose, (2 n + 3 + m + b, 6). carry: of these over a cycle in the
            filter, square.
        law: tensions wanted, by (x, velocity, tensions applied, force, tension errors, tensions that acted, force that
            acted), (m, 2 n + 3 + m + 3 + m + m + 3).
    """

    period: float
    step: Array
    pull: Array
    push: Array
    pose: Array
    decay: Array
    gain: Array
    carry: Array
    law: Array


def resting_tensions(setup: CycleSetup, angle: float) -> Array:
    """Return the tensions [N] under which the model rests, its tip turned by `angle` [rad] in the bending plane."""
    task: Any = setup.selection.task
    curve = setup.selection.curve
    if curve is None or not isinstance(setup.rod, GeneralRod):
        raise ParameterError("the margin of the filter needs the general rod, and a reference in the bending plane")
    net = curve.tension_at(float(np.interp(angle, curve.angle, curve.arc)))
    control, count = setup.config.control, len(setup.rod.robot.tendons)
    pull = np.zeros(count)
    pull[control.agonist] = net
    if isinstance(task, SpatialTask):
        return np.asarray(task.allocation.tensions(task.allocation.moment(pull)))
    if control.antagonist is not None:
        pull[[control.agonist, control.antagonist]] += task.pair_tension
    return pull


def plant_parts(rod: GeneralRod, mass: float, stiffness: float, tensions: Array) -> PlantParts:
    """Return the parts of a plant like the model `rod` but for a mass on its tip [kg] and a factor on its stiffness.

    It rests with the tip turned as the model's: under tensions that are larger or smaller.
    """
    steps = int(np.ceil(rod.time_step / FINEST - 1e-9))
    smooth = tuple(replace(one, friction=0.0) for one in rod.robot.tendons)
    bodies = (*rod.robot.bodies, Body(rod.robot.length, mass)) if mass > 0.0 else rod.robot.bodies
    plant = GeneralRod(
        replace(rod.robot, bodies=bodies, tendons=smooth), rod.time_step / steps, rod.compliance / stiffness
    )
    wanted = _turned(rod, rod.solve_static(tensions))
    low, high = 0.2, 3.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        if _turned(plant, plant.solve_static(middle * tensions)) < wanted:
            low = middle
        else:
            high = middle
    rest = plant.solve_static(0.5 * (low + high) * tensions)
    linear = Linearisation(plant.strain_rod)
    found = linear.step(rest.strain, plant.loads(rest.tensions))
    outputs = linear.outputs(rest.strain)
    taut = np.where(tensions > 0.0, 1.0, 0.0)
    step, pull = np.eye(len(found.a)), np.zeros_like(found.b)
    for _ in range(steps):
        step, pull = found.a @ step, found.a @ pull + found.b * taut
    modes = np.linalg.eigvals(found.a)
    fast = modes[(np.real(modes) < 0.0) & (np.abs(modes) ** steps > FAST)] ** steps
    return PlantParts(step, pull, np.concatenate((outputs.position, outputs.rotation)), fast)


def _turned(rod: GeneralRod, state: GeneralState) -> float:
    """Angle between the base's axis and the tip's [rad]."""
    along = rod.strain_rod.tip(state.strain)[1][:, 2] @ rod.robot.base[:, 2]
    return float(np.arccos(np.clip(along, -1.0, 1.0)))


def model_parts(setup: CycleSetup, tensions: Array) -> ModelParts:
    """Return the parts of a controller whose model rests under `tensions` [N], shape (m,)."""
    rod, estimator = setup.rod, setup.estimator
    if not isinstance(rod, GeneralRod) or estimator is None:
        raise ParameterError("the margin of the filter needs the general rod and observer.kind = 'kalman'")
    rest, errors = rod.solve_static(tensions), estimator.errors
    n, m, b, k = rod.strain_rod.modes, len(tensions), len(errors.bends), len(errors.kept)
    linear = Linearisation(rod.strain_rod)
    found = linear.step(rest.strain, rod.loads(tensions))
    outputs = linear.outputs(rest.strain)
    started = estimator.start(rest)
    unit = rod.parameters.bending_stiffness / rod.robot.length

    def bent(moments: Array) -> Array:
        after = estimator.step(replace(started, bend_error=moments), rest, tensions).strain
        return np.concatenate((after.strain, after.rate))

    push = np.column_stack((found.by_force, differences(bent, np.zeros(b), np.full(b, 1e-4 * unit))))
    gain, carry = _gain_and_carry(estimator, started, rest)
    causes = errors.stiffness - 2 * k
    keep = np.arange(2 * k + causes)
    whole = np.zeros((2 * n + causes, 2 * k + causes))
    whole[errors.kept, np.arange(k)] = 1.0
    whole[n + errors.kept, k + np.arange(k)] = 1.0
    whole[2 * n :, 2 * k :] = np.eye(causes)
    taut = np.where(tensions > 0.0, 1.0, 0.0)
    gain[errors.tension] *= taut[:, None]
    return ModelParts(
        period=rod.time_step, step=found.a, pull=found.b * taut, push=push,
        pose=np.concatenate((outputs.position, outputs.rotation)),
        decay=estimator.filter.decay[:causes].copy(),
        gain=whole @ gain[keep], carry=whole @ carry[np.ix_(keep, keep)] @ whole.T,
        law=law_matrix(setup, started, rest, m),
    )  # fmt: skip


def _gain_and_carry(estimator: Estimator, started: EstimatorState, rest: GeneralState) -> tuple[Array, Array]:
    """Return the filter's gain for a pose after `SETTLED`, shape (N, 6), and its transition, shape (N, N).

    Without an orientation's noise the last three columns are zero.
    """
    made, errors = estimator.filter, estimator.errors
    after = estimator.step(started, rest, rest.tensions)
    top = made.transition(rest, after)
    carry = np.zeros((errors.size, errors.size))
    carry[: len(top)] = top
    lower = np.arange(len(top), errors.size)
    carry[lower, lower] = made.decay
    noise = np.zeros(errors.size)
    noise[len(top) :] = made.step_noise(rest.tensions)
    pose = estimator.sensors[0]
    rows, variance = started.moments[-1].expected[0].rows, np.diag(pose.deviation**2)
    known = started.moments[0].factors.covariance
    gain = np.zeros((errors.size, 6))
    for _ in range(int(np.ceil(SETTLED / estimator.rod.time_step))):
        seen = known @ rows.T
        part = np.linalg.solve(rows @ seen + variance, seen.T).T
        known = known - part @ seen.T
        known = carry @ (0.5 * (known + known.T)) @ carry.T + np.diag(noise)
        gain[:, : len(rows)] = part
    return gain, carry
