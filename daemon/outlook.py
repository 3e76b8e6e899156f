"""What a law that looks ahead is told of the coming step, from the model's linearisation of it: no further solves."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.laws.law import Observation, Outlook
from tendond.daemon.state import CycleSetup, CycleState
from tendond.model.errors import ConvergenceError

Array = NDArray[np.float64]


def look_ahead(setup: CycleSetup, state: CycleState, observation: Observation, elapsed: float) -> Observation:
    """`observation` with an outlook on the step that comes; its position and target are then of what is aimed at.

    Args:
        setup: of the controller.
        state: before the step.
        observation: of the tip now.
        elapsed: time since tracking began [s].
    """
    choice, period = state.choice, setup.config.loop.period
    assert choice.allocation is not None
    rod, model = setup.rod, state.rod
    try:
        forecast = rod.forecast(model, state.tension, choice.allocation.shares, state.observer.tip_force)
    except ConvergenceError:  # the step itself will say so
        return replace(observation, outlook=None)
    then, target = choice.reference.goal(elapsed + period, state.slip), observation.target
    if choice.reference.aim == "direction":
        position, velocity = state.tip.rotation[:, 2], (forecast.direction - state.tip.rotation[:, 2]) / period
        ahead, answer = forecast.direction, forecast.direction_answer
        target = choice.reference.goal(elapsed).place
        target_velocity = (then.place - target) / period
    else:
        unseen, drift = _unseen(setup, state, observation)
        position, velocity = state.tip.position + unseen, observation.velocity + drift
        ahead, answer = forecast.position + unseen + period * drift, forecast.position_answer
        target_velocity = observation.target_velocity
    return replace(
        observation,
        position=position,
        velocity=velocity,
        target=target,
        target_velocity=target_velocity,
        outlook=Outlook(
            period=period,
            position=ahead,
            answer=answer,
            target=then.place,
            directions=then.answer,
            allocation=choice.allocation,
        ),
    )


def _unseen(setup: CycleSetup, state: CycleState, observation: Observation) -> tuple[Array, Array]:
    """Measured minus model tip now [m], and its rate [m/s], each of shape (3,).

    The force observer holds the model to the tip with a lag: on a circle, what is left of the innovation turns with the
    tip. Its low-pass m, and (innovation - m) / quiet_time, which is m's rate, carry it over the filter and the delay.
    """
    gains, observer = setup.observer, state.observer
    if gains.kind != "force":
        return observation.position - state.tip.position, np.zeros(3)
    drift = (observer.innovation - observer.mean) / gains.quiet_time
    return observer.mean + (gains.quiet_time + gains.delay) * drift, drift
