"""Admit, with a base that moves: take the pose and the markers of a cycle into the base's measured frame."""

from dataclasses import dataclass

from tendond.daemon.control.estimation.moving_base import (
    BasePose,
    base_at,
    base_name,
    base_poses,
    pose_in_base,
    readings_in_base,
)
from tendond.daemon.control.phases.monitors import ONE_CLOCK
from tendond.daemon.control.sensors import Reading
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.schemas.messages import TipPose
from tendond.schemas.record import CycleInputs

SIMULTANEOUS = 0.5
"""Share of a cycle by which a reading of the base may be younger than a pose and still count as taken with it."""


@dataclass(frozen=True)
class Framed:
    """What came in a cycle, in the base's frame.

    Attributes:
        pose: of the tip, if one came. published: its position as it came [m]; empty where no base is measured.
        readings: admitted ones. base: known poses of the base, the youngest first.
    """

    pose: TipPose | None
    published: tuple[float, ...]
    readings: tuple[Reading, ...]
    base: tuple[BasePose, ...]


def in_base_frame(
    setup: CycleSetup, state: CycleState, inputs: CycleInputs, admitted: tuple[Reading, ...], pose: TipPose | None
) -> Framed:
    """Return pose and readings in the base's frame; as they are where no sensor measures the base.

    Args:
        setup: setup of the cycle. state: after the last one. inputs: of the cycle.
        admitted: its admitted readings. pose: of the tip, not yet admitted; none where none came.
    """
    name = base_name(setup.sensors)
    if name is None:
        return Framed(pose, (), admitted, ())
    period = setup.config.loop.period
    base, slack = base_poses(state.base, name, admitted, period * (1 + inputs.missed_ticks)), SIMULTANEOUS * period
    readings = readings_in_base(setup.sensors, admitted, base, slack)
    if pose is None:
        return Framed(None, (), readings, base)
    own = pose_in_base(pose, base_at(base, _age(setup, state, inputs), slack))
    return Framed(own, pose.position, readings, base)


def _age(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> float:
    """Return the age of the cycle's pose [s], by its stamp where stamps are used; without `observer.command_delay`."""
    lag = inputs.pose_lag
    if not setup.config.observer.stamps or lag is None:
        return setup.config.observer.delay
    return lag if 0.0 <= lag < ONE_CLOCK else max(lag - state.stamp_age.lag_min, 0.0)
