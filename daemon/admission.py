"""Which inputs a cycle uses: each one that it does not use is named with its reason."""

import math
from dataclasses import dataclass, replace

import numpy as np

from tendond.daemon.state import CycleSetup, CycleState
from tendond.schemas.messages import TendonState, TipPose
from tendond.schemas.record import CycleInputs

REACH = 1.5
"""Rod lengths from the base beyond which no tip can be."""


@dataclass(frozen=True)
class Admission:
    """state: with the admitted inputs in it; fresh: a pose was admitted just now; rejected: what was not, and why."""

    state: CycleState
    fresh: bool
    rejected: tuple[str, ...]


def admit(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Admission:
    """Take over the inputs that can be trusted and age the rest."""
    rejected = [reason for reason, count in sorted(inputs.unreadable.items()) for _ in range(count)]
    reason = _objection(setup, state, inputs.pose) if inputs.pose is not None else None
    if reason is not None:
        rejected.append(reason)
    fresh = inputs.pose is not None and reason is None
    counts = dict(state.rejected)
    for name in rejected:
        counts[name] = counts.get(name, 0) + 1
    runs = replace(
        state.runs,
        rejected=0 if fresh else state.runs.rejected + len(rejected),
        teleports=0 if fresh else state.runs.teleports + (reason == "teleport"),
        missed_ticks=state.runs.missed_ticks + inputs.missed_ticks if inputs.missed_ticks else 0,
    )
    if fresh:
        earlier = None if state.pose is None else np.array(state.pose.position)
        interval = 1 + inputs.missed_ticks + (state.pose_age or 0)
        state = replace(state, pose=inputs.pose, pose_age=0, earlier=earlier, interval=interval)
    elif state.pose_age is not None:
        state = replace(state, pose_age=state.pose_age + 1 + inputs.missed_ticks)
    if inputs.tendon_state is not None:
        state = replace(state, tendon_state=_with_count_checked(setup, inputs.tendon_state))
    return Admission(replace(state, runs=runs, rejected=counts), fresh, tuple(rejected))


def _with_count_checked(setup: CycleSetup, tendons: TendonState) -> TendonState:
    """As it came, or with a fault where the driver has another number of tendons than the configuration."""
    count = setup.rod.parameters.tendon_count
    if len(tendons.tension) == count == len(tendons.displacement):
        return tendons
    return tendons.model_copy(
        update={"fault": f"{len(tendons.tension)} of them, where rod.tendon_positions has {count}"}
    )


def _objection(setup: CycleSetup, state: CycleState, pose: TipPose) -> str | None:
    """Why a pose cannot be used, if so."""
    if not pose.valid:
        return "occluded"
    if math.hypot(*pose.position) > REACH * setup.rod.parameters.length:
        return "out of reach"
    if state.pose is None or state.pose_age is None or state.pose_age > setup.config.faults.pose_stale:
        return None
    if pose.seq <= state.pose.seq:
        return "out of order"
    faults = setup.config.faults
    reach = faults.tip_speed_max * setup.config.loop.period * (state.pose_age + 1) + faults.teleport_margin
    if np.linalg.norm(np.subtract(pose.position, state.pose.position)) > reach:
        return "teleport"
    return None
