"""The entries of a cycle in the log: its record, poses and timing, at times the state before it and the rod's shape."""

from collections import deque
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from tendond.daemon.control.snapshot import StateSnapshot, encode_state
from tendond.daemon.control.state import CycleState
from tendond.daemon.recording import foxglove, scene
from tendond.daemon.recording.batch_queue import Message
from tendond.daemon.recording.channels import (
    CYCLE,
    ROD_SHAPE,
    STATE,
    TIMING,
    TIP_MEASURED,
    TIP_MODEL,
    TRANSFORMS,
    TRUTH,
)
from tendond.daemon.recording.contact_scene import contact_entity, no_contact
from tendond.daemon.recording.entities import SceneUpdate
from tendond.daemon.recording.thinning import Kept, Thinning
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import SimulatorTruth
from tendond.schemas.record import CycleRecord, LoopTiming

SNAPSHOT_SECONDS = 1.0
"""Time between two states in the log, each of which a replay can start from [s]."""


class Cycle(NamedTuple):
    """Data of a cycle that go into the log.

    Attributes:
        now: log time [ns].
        record: the record.
        before: the state before it.
        timing: its timing, where a clock ran.
        rod: the model's state after it.
        truth: the simulator's.
    """

    now: int
    record: CycleRecord
    before: CycleState | None
    timing: LoopTiming | None
    rod: ModelState
    truth: SimulatorTruth | None


class CycleEntries:
    """Makes the entries of cycles, of which some are held back or left out while the arm is idle.

    `begin`, `take` and `flush` are called in the recorder's thread: what is held back is known there alone.

    Args:
        config: configuration of the rig.
        rod: the controller's model, to draw its states.
    """

    def __init__(self, config: RigConfig, rod: ModelRod) -> None:
        self._rod = rod
        self._shape_period = config.log.shape_period
        self._snapshot_period = max(1, round(SNAPSHOT_SECONDS / config.loop.period))
        self._thinning: Thinning[Cycle] = Thinning(config.loop.period, config.log.idle_period)
        self._trail: deque[Vector3] = deque(maxlen=scene.TRAIL_POINTS)
        self._begun_tick: int | None = None
        self._contact = False

    @property
    def asleep(self) -> bool:
        """True if cycles are held back."""
        return self._thinning.asleep

    def count(self, cycle: Cycle) -> int:
        """Count the entries of a cycle, without the state before it."""
        optional = (cycle.timing, cycle.record.inputs.pose, cycle.truth)
        shape = 2 if self._has_shape(cycle.record) else 0
        return 2 + sum(one is not None for one in optional) + shape

    def is_snapshot_due(self, state: CycleState) -> bool:
        """True if this state is one of those that are logged once a second."""
        return state.tick % self._snapshot_period == 0

    def begin(self, state: CycleState, now: int) -> list[Message]:
        """Make the entry of a state that is due; none while cycles are held back, and it with the next one."""
        if self.asleep:
            return []
        self._begun_tick = state.tick
        return [(STATE, snapshot(state), now)]

    def take(self, cycle: Cycle) -> list[Message]:
        """Make the entries of a cycle, and of those before it that were held back; none while this one is held back."""
        return [entry for kept in self._thinning.take(cycle.record, cycle) for entry in self._entries(kept)]

    def flush(self) -> list[Message]:
        """Make the entries of the cycles that are held back, at the end."""
        return [entry for kept in self._thinning.flush() for entry in self._entries(kept)]

    def _has_shape(self, record: CycleRecord) -> bool:
        return record.tick % self._shape_period == 0

    def _entries(self, kept: Kept[Cycle]) -> Iterator[Message]:
        now, record, before, timing, state, truth = kept.more
        due = before is not None and self.is_snapshot_due(before) and before.tick != self._begun_tick
        if before is not None and (due or kept.left_out):
            yield (STATE, snapshot(before, kept.left_out), now)
        yield (CYCLE, record, now)
        if timing is not None:
            yield (TIMING, timing, now)
        pose = record.inputs.pose
        if pose is not None:
            yield (TIP_MEASURED, partial(foxglove.pose_in_frame, now, pose.position, pose.orientation), now)
        model = record.model
        yield (TIP_MODEL, partial(foxglove.pose_in_frame, now, model.position, model.orientation), now)
        if truth is not None:
            yield (TRUTH, truth, now)
        if self._has_shape(record):
            yield (ROD_SHAPE, partial(self._shape, now, record, state), now)
            yield (TRANSFORMS, partial(_frames, now, record), now)

    def _shape(self, now: int, record: CycleRecord, state: ModelState) -> SceneUpdate:
        points, tendons = self._rod.curve(state), self._rod.tendon_paths(state)
        self._trail.append(record.measured or record.model.position)
        known = scene.filter_entities(now, record.model.position, record.observer)
        found = None if record.observer.filter is None else record.observer.filter.contact
        if found is not None:
            places = found.place, found.first_place, found.last_place
            length = self._rod.parameters.length
            known += (contact_entity(now, points, length, places, found.force, found.force_deviation),)
        elif self._contact:
            known += (no_contact(now),)
        self._contact = found is not None
        return scene.rod_shape(now, record.tick, points, record.reference.position, tendons, self._trail, known)


def snapshot(state: CycleState, left_out: int = 0) -> StateSnapshot:
    """Return the message of a state, which becomes text when it is written."""
    return StateSnapshot(tick=state.tick, left_out=left_out, state=partial(encode_state, state))


def _frames(now: int, record: CycleRecord) -> foxglove.FrameTransforms:
    frames = {"tip_model": (record.model.position, record.model.orientation)}
    if record.inputs.pose is not None:
        frames["tip_measured"] = (record.inputs.pose.position, record.inputs.pose.orientation)
    return foxglove.frame_transforms(now, frames)
