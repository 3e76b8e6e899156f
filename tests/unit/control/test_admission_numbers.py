"""Counts of the admission of inputs, from one cycle to the next."""

from typing import Any

import pytest

from tendond.daemon.control.phases.admission import admit, describe_refusals
from tendond.daemon.control.sources import Source, Sources, hear
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.keys import TENDON_STATE, TIP_POSE
from tendond.schemas.messages import TendonState, TipPose
from tendond.schemas.record import CycleInputs
from tests.unit.control.cycles import REST, SETUP, START

ALLOWED = SETUP.thresholds
FAR = (REST[0], REST[1], -REST[2])
"""Further than a tip goes in a few cycles, and within reach."""


def pose(seq: int, position: tuple[float, ...] = REST, source: str = "", **changes: Any) -> TipPose:
    x, y, z = position
    return TipPose(seq=seq, stamp_ns=0, position=(x, y, z), orientation=(1.0, 0.0, 0.0, 0.0), source=source, **changes)


def tendons(seq: int, count: int = 4, source: str = "") -> TendonState:
    zeros = (0.0,) * count
    return TendonState(seq=seq, stamp_ns=0, displacement=zeros, tension=zeros, source=source)


def after(state: CycleState, *inputs: CycleInputs) -> CycleState:
    for one in inputs:
        state = changed(admit(SETUP, state, one).state, tick=state.tick + 1 + one.missed_ticks)
    return state


SEEN = after(START, CycleInputs(pose=pose(100), tendon_state=tendons(100)))


def test_refused_poses_are_counted_from_the_first_to_the_newest_with_the_reason_of_the_newest() -> None:
    state = after(SEEN, CycleInputs(pose=pose(101, FAR)))
    assert (state.bad_cycles.teleports, state.bad_cycles.rejected, state.bad_cycles.objection) == (1, 1, "teleport")
    state = after(state, CycleInputs(missed_ticks=1))
    assert (state.bad_cycles.teleports, state.bad_cycles.rejected, state.bad_cycles.objection) == (1, 1, "teleport")
    state = after(state, CycleInputs(pose=pose(102, FAR)))
    assert (state.bad_cycles.teleports, state.bad_cycles.rejected) == (4, 4)
    state = after(state, CycleInputs(pose=pose(103, (3.0, 0.0, 0.0))))
    assert (state.bad_cycles.teleports, state.bad_cycles.rejected, state.bad_cycles.objection) == (4, 5, "out of reach")
    state = after(state, CycleInputs(unreadable={"malformed": 1}))
    assert (state.bad_cycles.rejected, state.bad_cycles.objection) == (6, "out of reach")
    state = after(state, CycleInputs(pose=pose(104)))
    assert (state.bad_cycles.teleports, state.bad_cycles.rejected, state.bad_cycles.objection) == (0, 0, "")


def test_an_occluded_pose_is_no_bad_one_and_is_counted_for_itself_until_the_tip_is_seen_again() -> None:
    hidden = CycleInputs(pose=pose(101, valid=False))
    state = after(SEEN, hidden, hidden)
    assert (state.bad_cycles.occluded, state.bad_cycles.rejected) == (2, 0)
    state = after(state, CycleInputs())
    assert state.bad_cycles.occluded == 2
    assert after(state, CycleInputs(pose=pose(102))).bad_cycles.occluded == 0


def test_equal_poses_are_counted_in_cycles_with_those_that_had_none_and_the_missed_ones() -> None:
    state = after(SEEN, CycleInputs(pose=pose(101)))
    assert state.bad_cycles.equal_poses == 1
    state = after(state, CycleInputs(), CycleInputs(), CycleInputs(pose=pose(102), missed_ticks=1))
    assert state.bad_cycles.equal_poses == 5
    assert after(state, CycleInputs(pose=pose(103, (*REST[:2], REST[2] + 1e-6)))).bad_cycles.equal_poses == 0


def test_the_path_length_of_the_model_since_the_pose_changed_is_kept_while_poses_are_equal() -> None:
    state = changed(SEEN, path_length=0.02)
    assert after(state, CycleInputs(pose=pose(101))).path_length == 0.02
    assert after(state, CycleInputs(pose=pose(101, (*REST[:2], REST[2] + 1e-6)))).path_length == 0.0


@pytest.mark.parametrize(("cycles", "missed", "interval"), [(0, 0, 1), (2, 0, 3), (2, 4, 7)])
def test_the_interval_of_reports_is_counted_in_cycles_for_poses_and_tendons(
    cycles: int, missed: int, interval: int
) -> None:
    state = after(SEEN, *[CycleInputs()] * cycles)
    state = after(state, CycleInputs(pose=pose(101), tendon_state=tendons(101), missed_ticks=missed))
    assert (state.pose_interval, state.pose_age) == (interval, 0)
    assert (state.tendon_interval, state.tendon_age) == (interval, 0)


def test_missed_deadlines_in_a_row_end_with_a_cycle_in_time() -> None:
    state = after(SEEN, CycleInputs(missed_ticks=2), CycleInputs(missed_ticks=3))
    assert state.bad_cycles.missed_ticks == 5
    assert after(state, CycleInputs()).bad_cycles.missed_ticks == 0


PROBED = changed(
    after(START, CycleInputs(pose=pose(100, source="vicon-1"), tendon_state=tendons(100, source="servo-1"))),
    commissioned=True,
)


@pytest.mark.parametrize(
    ("inputs", "still"),
    [
        (CycleInputs(), True),
        (CycleInputs(pose=pose(101, source="vicon-1"), tendon_state=tendons(101, source="servo-1")), True),
        (CycleInputs(tendon_state=tendons(100, source="servo-1")), True),  # refused: out of order
        (CycleInputs(pose=pose(101, FAR, source="vicon-1")), True),  # refused: a teleport
    ],
)
def test_what_was_probed_stays_probed_while_camera_and_servo_driver_are_the_same(
    inputs: CycleInputs, still: bool
) -> None:
    assert after(PROBED, inputs).commissioned is still
    assert not after(changed(PROBED, commissioned=False), inputs).commissioned


@pytest.mark.parametrize(
    "inputs",
    [
        CycleInputs(pose=pose(101, source="vicon-2")),
        CycleInputs(tendon_state=tendons(101, source="servo-2")),
        CycleInputs(pose=pose(5, source="vicon-1")),  # started anew, with a count of its own
        CycleInputs(tendon_state=tendons(5, source="servo-1")),
    ],
)
def test_another_camera_or_servo_driver_or_one_started_anew_is_to_be_probed_again(inputs: CycleInputs) -> None:
    silence = [CycleInputs()] * (1 + max(ALLOWED.pose_timeout, ALLOWED.tendon_timeout))
    state = after(PROBED, *silence)
    assert state.commissioned
    assert not after(state, inputs).commissioned


def test_a_driver_with_another_number_of_tendons_is_a_fault_of_the_tendons() -> None:
    state = after(SEEN, CycleInputs(tendon_state=tendons(101, count=3)))
    assert state.tendon_state is not None
    assert state.tendon_state.fault == "3 of them, where rod.tendon_positions has 4"


def test_a_tendon_driver_may_count_anew_after_its_time_and_not_before() -> None:
    silence = [CycleInputs()] * (ALLOWED.tendon_timeout - 1)
    late = admit(SETUP, after(SEEN, *silence), CycleInputs(tendon_state=tendons(1)))
    assert late.rejected == ("tendons out of order",)
    late = admit(SETUP, after(SEEN, *silence, CycleInputs()), CycleInputs(tendon_state=tendons(1)))
    assert late.rejected == ("tendons out of order",)
    late = admit(SETUP, after(SEEN, *silence, CycleInputs(), CycleInputs()), CycleInputs(tendon_state=tendons(1)))
    assert late.rejected == ()


def test_messages_of_other_sources_are_refused_and_counted_one_by_one() -> None:
    inputs = CycleInputs(
        pose=pose(1, source="vicon-2"), tendon_state=tendons(1, source="servo-2"), others={TIP_POSE: "vicon-3"}
    )
    admission = admit(SETUP, PROBED, inputs)
    assert admission.rejected == ("another source",) * 3
    assert not admission.fresh
    assert admission.state.pose == PROBED.pose
    assert admission.state.tendon_state == PROBED.tendon_state
    assert admission.state.rejected["another source"] == 3


def test_refusals_are_summed_up_without_those_of_the_tendons() -> None:
    state = changed(START, rejected={"out of reach": 2, "malformed": 1, "tendons out of order": 9})
    assert describe_refusals(state) == (
        "3 poses arrived, all refused: 2 out of reach (are they in mm? metres are expected), 1 malformed"
    )


def test_two_sources_are_reported_by_their_names_or_as_ones_without() -> None:
    two = Sources(
        {TIP_POSE: Source("a", 1), TENDON_STATE: Source("", 1)},
        {TIP_POSE: Source("b", 1), TENDON_STATE: Source("c", 1)},
    )
    assert two.in_words() == (
        f"two sources of {TIP_POSE}: 'a' and 'b'; two sources of {TENDON_STATE}: one without a name and 'c': end one "
        "of them"
    )
    assert Sources({}, {TIP_POSE: Source("b", 1)}).in_words() == (
        f"two sources of {TIP_POSE}: one without a name and 'b': end one of them"
    )


@pytest.mark.parametrize(("silence", "pulling", "taken"), [(20, False, False), (21, False, True), (21, True, False)])
def test_another_source_is_followed_once_the_first_is_silent_and_nothing_is_pulled(
    silence: int, pulling: bool, taken: bool
) -> None:
    sources = Sources({TIP_POSE: Source("a", 1000)}, {})
    alive = {TIP_POSE: 20, TENDON_STATE: 20}
    heard = hear(sources, 1000 + silence, CycleInputs(pose=pose(1, source="b")), alive, 300, pulling=pulling)
    assert heard.pose_refused is not taken
    assert heard.sources.followed[TIP_POSE].name == ("b" if taken else "a")


@pytest.mark.parametrize(("later", "remembered"), [(300, True), (301, False)])
def test_another_source_is_remembered_for_its_time(later: int, remembered: bool) -> None:
    sources = Sources({TIP_POSE: Source("a", 1000)}, {TIP_POSE: Source("b", 1000)})
    heard = hear(sources, 1000 + later, CycleInputs(), {TIP_POSE: 20, TENDON_STATE: 20}, 300, pulling=False)
    assert (TIP_POSE in heard.sources.others) is remembered


def test_a_tendon_state_is_heard_in_a_cycle_without_a_pose() -> None:
    alive = {TIP_POSE: 20, TENDON_STATE: 20}
    heard = hear(Sources({}, {}), 5, CycleInputs(tendon_state=tendons(1, source="s")), alive, 300, pulling=False)
    assert heard.sources.followed == {TENDON_STATE: Source("s", 5)}


def test_a_source_that_is_followed_now_is_no_other_one_any_more() -> None:
    sources = Sources({TIP_POSE: Source("a", 1)}, {TIP_POSE: Source("b", 1000)})
    alive = {TIP_POSE: 20, TENDON_STATE: 20}
    heard = hear(sources, 1001, CycleInputs(pose=pose(1, source="b")), alive, 300, pulling=False)
    assert heard.sources == Sources({TIP_POSE: Source("b", 1001)}, {})
