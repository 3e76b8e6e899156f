"""Admit: select the inputs that a cycle uses, and give the reason for each one that it does not use."""

import math
from dataclasses import dataclass

import numpy as np

from tendond.daemon.control.phases.base_frame import in_base_frame
from tendond.daemon.control.phases.readings import admit_readings
from tendond.daemon.control.sensors import is_sensors
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.sources import Sources, hear, with_unnamed, without_sensors
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.keys import TENDON_STATE, TIP_POSE
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs

REACH = 1.5
"""Rod lengths from the base beyond which no tip can be: an inextensible rod reaches 1, and 0.5 is the most that
`commissioning.offset` may be. Chosen; lengths in another unit are wrong by a factor of 39 and more."""

OCCLUDED = "occluded"
ANOTHER_SOURCE = "another source"
OUT_OF_ORDER = "out of order"
ANEW = "count starts anew"
REORDERED = 64
"""Counts by which a pose may be late and still be of the same run: as many as are kept between two cycles."""

REMARKS = {
    "out of reach": " (are they in mm? metres are expected)",
    OCCLUDED: " (valid = false: does the camera see the tip?)",
    "bad quaternion": " (a unit quaternion w, x, y, z is expected)",
    "wrong version": " (is the same version of tendond running everywhere?)",
}
"""Usual causes of a reason for refusal."""


@dataclass(frozen=True)
class Admission:
    """state: with the admitted inputs in it; fresh: a pose was admitted just now; rejected: what was not, and why."""

    state: CycleState
    fresh: bool
    rejected: tuple[str, ...]


def admit(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Admission:
    """Take over the inputs that can be trusted and age the rest."""
    missed, runs, allowed = inputs.missed_ticks, state.bad_cycles, setup.thresholds
    alive = {TIP_POSE: allowed.pose_timeout, TENDON_STATE: allowed.tendon_timeout}
    pulling = state.mode not in (Mode.STARTING, Mode.IDLE, Mode.FAULT)
    heard = hear(state.sources, state.tick, inputs, alive, allowed.source_time, pulling=pulling)
    tendons = None if heard.tendons_refused else inputs.tendon_state
    readings = admit_readings(setup, state, inputs, pulling=pulling)
    framed = in_base_frame(setup, state, inputs, readings.admitted, None if heard.pose_refused else inputs.pose)
    pose, as_published = framed.pose, framed.published
    unreadable = {reason: count for reason, count in sorted(inputs.unreadable.items()) if not is_sensors(reason)}
    rejected = [reason for reason, count in unreadable.items() for _ in range(count)]
    objection = None if pose is None else _objection(setup, state, pose)
    if objection is not None:
        rejected.append(objection)
    fresh = pose is not None and objection is None
    hidden = objection == OCCLUDED
    since_pose = runs.since_pose + 1 + missed
    bad = 0 if fresh else lengthened(runs.rejected, since_pose) if len(rejected) > hidden else runs.rejected
    teleports = 0 if fresh else lengthened(runs.teleports, since_pose) if objection == "teleport" else runs.teleports
    if pose is not None or rejected:
        since_pose = 0
    sources = heard.sources
    disorder, since_disorder = _disorder(setup, state, inputs, objection, pose if fresh else None)
    if fresh and disorder >= allowed.pose_timeout:
        sources = with_unnamed(sources, TIP_POSE, state.tick)
    late = None if tendons is None else _late(setup, state, tendons)
    if late is not None:
        rejected.append(late)
    foreign = heard.pose_refused + heard.tendons_refused + len(without_sensors(inputs.others))
    rejected += [*[ANOTHER_SOURCE] * foreign, *readings.rejected]
    counts = state.rejected
    if rejected:
        counts = dict(counts)
        for name in rejected:
            counts[name] = counts.get(name, 0) + 1

    age, interval = state.pose_age, state.pose_interval
    previous, path_length, equal = state.previous_position, state.path_length, runs.equal_poses
    if fresh and pose is not None:
        same = state.pose is not None and (state.published or state.pose.position) == (as_published or pose.position)
        equal, path_length = (lengthened(equal, 1 + missed + (age or 0)), path_length) if same else (0, 0.0)
        previous = None if state.pose is None else np.array(state.pose.position)
        interval, age = 1 + missed + (age or 0), 0
    elif age is not None:
        age += 1 + missed
    tendon_state, tendon_age, tendon_interval = state.tendon_state, state.tendon_age + 1 + missed, state.tendon_interval
    if tendons is not None and late is None:
        tendon_state, tendon_age, tendon_interval = _with_count_checked(setup, tendons), 0, tendon_age
    runs = changed(
        runs,
        rejected=bad,
        teleports=teleports,
        missed_ticks=runs.missed_ticks + missed if missed else 0,
        equal_poses=equal,
        occluded=0 if fresh else runs.occluded + hidden,
        objection=(objection or runs.objection) if bad else "",
        since_pose=since_pose,
        disorder=disorder,
        since_disorder=since_disorder,
    )
    state = changed(
        state,
        pose=pose if fresh else state.pose,
        pose_age=age,
        previous_position=previous,
        pose_interval=interval,
        path_length=path_length,
        tendon_state=tendon_state,
        tendon_age=tendon_age,
        tendon_interval=tendon_interval,
        bad_cycles=runs,
        sources=sources,
        commissioned=state.commissioned and not _renewed(state, sources, pose if fresh else None, tendon_state),
        rejected=counts,
        sensors=readings.tracks,
        readings=framed.readings,
        base=framed.base,
        published=as_published if fresh else state.published,
        unreadable=state.unreadable or inputs.unreadable_detail,
    )
    return Admission(state, fresh, tuple(rejected))


def _renewed(state: CycleState, sources: Sources, pose: TipPose | None, tendons: TendonState | None) -> bool:
    """True if camera or servo driver are others than before, or have started anew: what was probed may have changed."""
    before = state.sources.followed
    if any(topic in before and before[topic].name != one.name for topic, one in sources.followed.items()):
        return True
    counted_anew = tendons is not None and state.tendon_state is not None and tendons.seq < state.tendon_state.seq
    return counted_anew or (pose is not None and state.pose is not None and pose.seq <= state.pose.seq)


def _disorder(
    setup: CycleSetup, state: CycleState, inputs: CycleInputs, objection: str | None, fresh: TipPose | None
) -> tuple[int, int]:
    """Count the cycles for which poses have repeatedly come out of order, and those since the last one.

    One publisher's poses do not: where others are used meanwhile, two publishers without names count each for itself.
    """
    runs, missed = state.bad_cycles, inputs.missed_ticks
    since = runs.since_disorder + 1 + missed
    if fresh is not None and state.pose is not None and fresh.seq <= state.pose.seq:  # a count that started anew
        return 0, 0
    if objection in (OUT_OF_ORDER, ANEW) or OUT_OF_ORDER in inputs.unreadable:
        return (runs.disorder + since if runs.disorder else 1), 0
    return (0 if since > setup.thresholds.pose_timeout else runs.disorder), since


def lengthened(run: int, cycles: int) -> int:
    """Return the length of a run of bad reports with one more, `cycles` after the last; the first counts as one."""
    return run + cycles if run else 1


def describe_refusals(state: CycleState) -> str:
    """Describe what was refused so far, and its likely cause; empty where a pose is in use and all is readable.

    "304 poses arrived, all refused: 304 out of reach (are they in mm?)"
    """
    malformed = f"malformed messages, the first: {state.unreadable}" if state.unreadable else ""
    if state.pose is not None:
        return malformed
    counts = {
        name: count for name, count in state.rejected.items() if not (name.startswith("tendons") or is_sensors(name))
    }
    if not counts:
        return ""
    total = sum(counts.values())
    reasons = ", ".join(f"{count} {name}{REMARKS.get(name, '')}" for name, count in counts.items())
    text = f"{total} {'pose' if total == 1 else 'poses'} arrived, all refused: {reasons}"
    return f"{text}; {malformed}" if malformed else text


def _late(setup: CycleSetup, state: CycleState, tendons: TendonState) -> str | None:
    """Return the reason against a tendon state, if any; a driver that has started anew counts from zero again."""
    if state.tendon_state is None or state.tendon_age > setup.thresholds.tendon_timeout:
        return None
    return None if tendons.seq > state.tendon_state.seq else "tendons out of order"


def _with_count_checked(setup: CycleSetup, tendons: TendonState) -> TendonState:
    """Return the report, with a fault where the driver has another number of tendons than the configuration."""
    count = setup.rod.parameters.tendon_count
    if len(tendons.tension) == count == len(tendons.displacement):
        return tendons
    return tendons.model_copy(
        update={"fault": f"{len(tendons.tension)} of them, where rod.tendon_positions has {count}"}
    )


def _objection(setup: CycleSetup, state: CycleState, pose: TipPose) -> str | None:
    """Return the reason against a pose, if there is one."""
    if not pose.valid:
        return OCCLUDED
    if math.hypot(*pose.position) > REACH * setup.rod.parameters.length:
        return "out of reach"
    if state.pose is None or state.pose_age is None or state.pose_age > setup.thresholds.pose_timeout:
        return None
    if pose.seq <= state.pose.seq:
        return ANEW if pose.seq < state.pose.seq - REORDERED else OUT_OF_ORDER
    # A tip may have gone further in cycles without a pose, but not in those that have already shown it elsewhere:
    # a jump that lasts would else be believed as soon as enough of them had been refused.
    faults, unseen = setup.config.faults, state.pose_age + 1 - state.bad_cycles.teleports
    reach = faults.tip_speed_max * setup.config.loop.period * unseen + faults.teleport_margin
    if math.dist(pose.position, state.pose.position) > reach:
        return "teleport"
    return None
