"""Jog: the target in motion by hand, in the place of the reference while the rig tracks."""

from dataclasses import replace

from tendond.daemon.control.jog.jog import JogBounds, moved_reference, start_jog
from tendond.daemon.control.phases.decision import tracking_time
from tendond.daemon.control.phases.modes import Reply
from tendond.daemon.control.reference.planar import REACHED, PlanarReference
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction


def jog(setup: CycleSetup, state: CycleState, inputs: CycleInputs, reply: Reply) -> tuple[CycleState, Reply]:
    """Take a streamed speed, move the target by a cycle, and put it in the reference's place.

    The selection of the state returned is that of this cycle alone. Without a newer request within `teleop.timeout` the
    target slows down and holds its place; when tracking ends so does the motion by hand.
    """
    if state.mode is not Mode.TRACKING:
        state = state if state.jog is None else changed(state, jog=None)
        if inputs.request is ControlAction.JOG:
            remedy = "reset first" if state.mode is Mode.FAULT else "arm first"
            reply = Reply(False, f"not moved: {state.mode.value}; {remedy}")
        return state, reply
    asked = inputs.request is ControlAction.JOG and inputs.jog is not None
    if state.jog is None and not asked:
        return state, reply
    reference, now = state.selection.task.reference, tracking_time(setup, state)
    if not isinstance(reference, PlanarReference):
        return state, Reply(False, "not moved: the reference is in space; select one in the bending plane first")
    tension_max = state.tuning.present.get("limits.tension_max", setup.config.limits.tension_max)
    bounds = JogBounds.of(setup.config, reference.curve, tension_max)
    motion = state.jog
    if motion is None:
        motion = start_jog(reference, now, REACHED * setup.rod.parameters.length)
        if motion is None:
            return state, Reply(False, "not moved: the reference is not where the tip can rest; wait until it is")
        if abs(motion.speed) > bounds.speed:
            text = f"the reference still moves at {abs(motion.speed):.2f} m/s, faster than {bounds.speed:.2f} m/s"
            return state, Reply(False, f"not moved: {text}; wait until it is slower")
    if asked and inputs.jog is not None:
        motion = motion.ask(inputs.jog, bounds)
        at_end = (motion.wanted > 0.0 and motion.arc >= bounds.last) or (
            motion.wanted < 0.0 and motion.arc <= bounds.first
        )
        reply = Reply(True, "at the end of the workspace" if at_end else "moving" if motion.wanted else "holding")
    motion = motion.advance(bounds, setup.config.loop.period)
    moved = moved_reference(reference, motion, bounds, now)
    task = replace(state.selection.task, reference=moved)
    return changed(state, jog=motion, selection=replace(state.selection, task=task)), reply
