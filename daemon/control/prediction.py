"""What a law that looks ahead is told of the coming step, from the model's linearisation of it: no further solves."""

from dataclasses import replace

from tendond.daemon.control.laws.law import Observation, Outlook
from tendond.daemon.control.state import CycleSetup, CycleState
from tendond.model.errors import ConvergenceError


def look_ahead(setup: CycleSetup, state: CycleState, observation: Observation, elapsed: float) -> Observation:
    """`observation` with an outlook on the step that comes; its position and target are then of what is aimed at.

    Args:
        setup: of the controller.
        state: before the step.
        observation: of the tip now.
        elapsed: time since tracking began [s].
    """
    selection, period = state.selection, setup.config.loop.period
    assert selection.allocation is not None
    rod, model = setup.rod, state.rod
    try:
        forecast = rod.predict(model, state.tension_estimate, selection.allocation.shares, state.observer.tip_force)
    except ConvergenceError:  # the step itself will say so
        return replace(observation, outlook=None)
    then, target = selection.reference.goal(elapsed + period, state.reference_offset), observation.target
    if selection.reference.aim == "direction":
        position, velocity = state.tip.rotation[:, 2], (forecast.direction - state.tip.rotation[:, 2]) / period
        ahead, answer = forecast.direction, forecast.direction_jacobian
        target = selection.reference.goal(elapsed).place
        target_velocity = (then.place - target) / period
    else:
        position, velocity = observation.position, observation.velocity
        unseen = position - state.tip.position  # beside the model's tip: of an observer of kind 'offset'
        ahead, answer = forecast.position + unseen, forecast.position_jacobian
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
            allocation=selection.allocation,
        ),
    )
