"""Limit and predict: bound the tension wanted, advance the model under it, and bound the displacement that it takes."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import attainable, follow, lead, limit_displacement, limit_tension
from tendond.daemon.control.commissioning.probe import TAKE_UP
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.phases.modes import ACTIVE, enter
from tendond.daemon.control.servos import compensate, pulling_rates, servos_at
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import BadCycles, CycleState, changed
from tendond.model.errors import ConvergenceError
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralState
from tendond.model.rods.interface import ModelState
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.messages import Mode

Array = NDArray[np.float64]


class Limited(NamedTuple):
    """A tension command within its limits [N], shape (n,), and the names of those that it met."""

    tension: Array
    met: tuple[str, ...]


class Predicted(NamedTuple):
    """The model after the step.

    Attributes:
        state: with the new rod, tensions and displacements.
        held_back: displacement limits were met.
        met: names of all limits that the command met.
        error: reason of the model's step without a solution; empty if it has one.
    """

    state: CycleState
    held_back: bool
    met: tuple[str, ...]
    error: str


class _Step(NamedTuple):
    """state: after the model's step; asked, command: displacement before and within limits [m]; met: their names."""

    state: CycleState
    asked: Array
    command: Array
    met: tuple[str, ...]
    error: str


def limit(setup: CycleSetup, state: CycleState, wanted: Array) -> Limited:
    """Bound the tension wanted [N] in value and rate; in modes that are not active, release at the release rate."""
    period = setup.config.loop.period
    if state.mode not in ACTIVE:
        step = setup.config.limits.release_rate * period
        return Limited(np.maximum(state.tension_command - step, 0.0), ())
    ahead = lead(wanted, state.tension_estimate, setup.lag_factor)
    return Limited(*limit_tension(limits_of(setup, state), period, ahead, state.tension_command))


def limits_of(setup: CycleSetup, state: CycleState) -> LimitsSection:
    """Return the limits of the mode: the probe has its own."""
    return setup.probe_limits if state.mode is Mode.PROBE else setup.config.limits


def predict(setup: CycleSetup, state: CycleState, limited: Limited) -> Predicted:
    """Advance the model under the command, as far as the displacement can follow it in this cycle.

    A tension step whose displacement is beyond its limits is taken in part only. A command that is not finite is
    replaced by a slack one, and the mode by a fault.
    """
    command, met = limited.tension, limited.met
    step = _advance(setup, state, command)
    if step.met and state.mode in ACTIVE:  # what the displacement cannot follow is not pulled
        held = _advance(setup, state, state.tension_estimate)
        part = attainable(held.asked, step.asked, step.command)
        met += step.met
        reached = _partial(setup, state, command, part)
        unchanged = np.array_equal(reached, held.state.tension_command)
        step = held if unchanged else _advance(setup, state, reached)
    after = step.state
    if not (_finite(after.tension_command) and _finite(after.displacement_command)):
        zeros = np.zeros_like(after.tension_command)
        after = changed(
            enter(after, Mode.FAULT, "the command was not finite"),
            tension_command=zeros,
            tension_estimate=zeros,
            displacement_estimate=zeros,
            displacement_command=zeros,
            servo_motion=None,
        )
    return Predicted(_remembered(setup, state, after), bool(step.met), met, step.error)


def _remembered(setup: CycleSetup, before: CycleState, after: CycleState) -> CycleState:
    """Return the state with the model's step in the estimator's memory."""
    observer, old, new = after.observer, before.rod, after.rod
    if setup.estimator is None or not isinstance(observer, EstimatorState):
        return after
    assert isinstance(old, GeneralState)
    assert isinstance(new, GeneralState)
    return changed(after, observer=setup.estimator.advance(observer, old, new))


def _partial(setup: CycleSetup, state: CycleState, command: Array, part: float) -> Array:
    """Return the part of a tension step that can be followed [N], shape (n,)."""
    reached = state.tension_estimate + part * (command - state.tension_estimate)
    # Where actuators lag, the tension commanded last is not the one applied: the rate limit is on the command.
    step = limits_of(setup, state).tension_rate * setup.config.loop.period
    reached = np.clip(reached, state.tension_command - step, state.tension_command + step)
    # A released tendon ends slack: a remainder of its tension would hold its displacement at the rate limit.
    return np.where((command == 0.0) & (reached < setup.slack), 0.0, reached)


def _advance(setup: CycleSetup, state: CycleState, command: Array) -> _Step:
    """Advance the model under the tension that follows from `command` [N], and compute the displacement it takes.

    The displacement follows from the model's shape. Where the model has no solution, it is held while the arm is
    active, and released in proportion to the tension otherwise.
    """
    config = setup.config
    tension = follow(command, state.tension_estimate, setup.lag_factor)
    if setup.lag_factor:
        tension = np.where((command == 0.0) & (tension < setup.slack), 0.0, tension)
    rod, bad, error = _advance_model(setup, state, tension)
    if error:
        total = float(np.sum(state.tension_estimate))
        left = 1.0 if state.mode in ACTIVE else float(np.sum(tension)) / total if total > 0.0 else 0.0
        estimate = state.displacement_estimate
        wanted = np.where(estimate > 0.0, left * estimate, estimate)
    else:
        wanted = setup.rod.displacements(rod, elastic=config.rod.has_elastic_tendons)
    release = max(config.limits.slack, setup.probe.slack) if state.mode is Mode.PROBE else config.limits.slack
    slack = np.where(tension > 0.0, 0.0, 0.0 if error else release)
    last, estimate, motion = state.displacement_command, state.displacement_estimate, state.servo_motion
    asked, beyond = lead(wanted - slack, estimate, setup.lag_factor), np.zeros_like(wanted)
    if setup.servo is not None:
        motion = servos_at(wanted - slack) if motion is None or state.mode is Mode.PROBE else motion
        beyond, motion = compensate(setup.servo, motion, wanted - slack, config.loop.period)
        asked = asked + beyond
    if state.mode is Mode.PROBE and state.probe is not None:  # slowly: a tendon that is wired wrongly is pulled by it
        rests = state.probe.phase is Phase.REST
        if rests and state.probe.since <= 1:
            last = estimate = wanted if state.probe.held is None else np.array(state.probe.held)
        slow = setup.probe.rate * config.loop.period
        up, down = (slow, slow) if rests else (TAKE_UP * slow, config.limits.displacement_rate * config.loop.period)
        if rests and state.probe.held is not None:  # release only: the model may still be approaching the arm
            wanted = np.minimum(wanted, state.probe.held)
        asked = np.clip(wanted - slack, last - down, last + up)
    pulling = pulling_rates(setup.servo, state.tension_estimate)
    displacement, met = limit_displacement(config.limits, config.loop.period, asked, last, pulling)
    after = changed(
        state,
        rod=rod,
        bad_cycles=bad,
        tension_estimate=tension,
        tension_command=command,
        displacement_estimate=follow(displacement - beyond, estimate, setup.lag_factor),
        displacement_command=displacement,
        servo_motion=motion,
    )
    return _Step(after, asked, displacement, met, error)


def _advance_model(setup: CycleSetup, state: CycleState, tension: Array) -> tuple[ModelState, BadCycles, str]:
    """Advance the model by a step; where that has no solution, without the observer's pull; else leave it as it is.

    Returns:
        The rod, the counts with those of steps without a solution, and the reason if there is none.
    """
    observer, bad, error = state.observer, state.bad_cycles, ""
    if setup.estimator is not None and isinstance(observer, EstimatorState) and isinstance(state.rod, GeneralState):
        try:
            rod = setup.estimator.step(observer, state.rod, tension)
            return rod, changed(bad, solver_failures=0) if bad.solver_failures else bad, ""
        except ConvergenceError as failure:
            return state.rod, changed(bad, solver_failures=bad.solver_failures + 1), str(failure)
    for force in (observer.tip_force, observer.force):
        try:
            rod = setup.rod.step(state.rod, tension, tip_force=force)
            return rod, changed(bad, solver_failures=0) if bad.solver_failures else bad, ""
        except ConvergenceError as failure:
            error = str(failure)
    return state.rod, changed(bad, solver_failures=bad.solver_failures + 1), error


def _finite(values: Array) -> bool:
    return all(map(math.isfinite, values.tolist()))
