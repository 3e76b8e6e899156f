"""What a law that looks ahead is told of the coming step, from the model's linearisation of it: no further solves."""

from dataclasses import replace

import numpy as np

from tendond.daemon.laws.law import Observation, Outlook
from tendond.daemon.state import CycleSetup, CycleState
from tendond.model.errors import ConvergenceError


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
        forecast = rod.forecast(model, state.tension, tip_force=state.observer.tip_force)
    except ConvergenceError:  # the step itself will say so
        return replace(observation, outlook=None)
    now, then = (choice.reference.goal(time, state.slip) for time in (elapsed, elapsed + period))
    if choice.reference.aim == "direction":
        position, ahead, answer = state.tip.rotation[:, 2], forecast.direction, forecast.sensitivity.direction_actuation
    else:
        unseen = observation.position - state.tip.position
        position, ahead = observation.position, forecast.position + unseen
        answer = forecast.sensitivity.position_actuation
    return replace(
        observation,
        position=position,
        target=now.place,
        outlook=Outlook(
            period=period,
            position=ahead,
            # per bending moment: the tendons' answers are its, but for what pulling all of them does
            answer=np.einsum("ij,kj->ik", answer, choice.allocation.shares),
            target=then.place,
            directions=then.answer,
            allocation=choice.allocation,
        ),
    )
