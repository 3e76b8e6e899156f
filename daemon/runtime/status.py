"""The controller's status, from state and record of a cycle."""

import time

from tendond.daemon.control.phases.admission import describe_refusals
from tendond.daemon.control.sources import Sources
from tendond.daemon.control.state import CycleState
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import LoopHealth, Status
from tendond.schemas.record import CycleRecord


def status_of(config: RigConfig, state: CycleState, record: CycleRecord, seq: int, health: LoopHealth) -> Status:
    """Return the status after a cycle.

    Args:
        config: configuration of the rig.
        state: state after the cycle.
        record: record of the cycle.
        seq: count of the status.
        health: health of the loop.
    """
    return Status(
        seq=seq,
        stamp_ns=time.monotonic_ns(),
        rig=config.rig.name,
        mode=record.mode,
        reason=record.reason,
        tick=record.tick,
        law=record.law,
        feedback=config.control.feedback,
        tip=record.measured,
        target=record.reference.target,
        tension=record.command.tension,
        tension_estimate=record.tension_estimate,
        displacement=record.command.displacement,
        rejected=state.rejected,
        sources=_names(state.sources),
        refused=describe_refusals(state),
        loop=health,
    )


def _names(sources: Sources) -> dict[str, tuple[str, ...]]:
    """Return identities by key: the followed publisher's first, then that of another one."""
    names: dict[str, tuple[str, ...]] = {topic: (one.name,) for topic, one in sources.followed.items()}
    for topic, other in sources.others.items():
        names[topic] = (*names.get(topic, ()), other.name)
    return names
