"""The fault table by the number: what ends tracking, from which value on, and in which words."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.phases.faults import find_fault, slack_tendon
from tendond.daemon.control.phases.modes import is_taut
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.messages import TendonState
from tests.unit.control.cycles import SETUP, START, armed

ALLOWED, FAULTS, PERIOD = SETUP.thresholds, SETUP.config.faults, SETUP.config.loop.period
TRACKING = armed()


def seconds(cycles: int) -> str:
    return f"{cycles * PERIOD:.3g} s"


def with_runs(**runs: int | str) -> CycleState:
    return changed(TRACKING, bad_cycles=changed(TRACKING.bad_cycles, **runs))


def report(*tension: float, fault: str = "") -> TendonState:
    return TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * len(tension), tension=tension, fault=fault)


def test_a_run_in_which_all_is_well_has_no_fault() -> None:
    assert find_fault(SETUP, TRACKING) == ""


@pytest.mark.parametrize(
    ("name", "allowed", "more", "words"),
    [
        ("missed_ticks", ALLOWED.overrun_time - 1, {}, "overrun: {n} deadlines missed in a row"),
        ("teleports", ALLOWED.teleport_time - 1, {}, "teleport: poses beyond what the tip can do for {t}"),
        ("rejected", ALLOWED.rejected_time - 1, {"objection": "teleport"}, "bad poses: teleport for {t}"),
        ("rejected", ALLOWED.rejected_time - 1, {"objection": ""}, "bad poses: unreadable for {t}"),
        ("solver_failures", ALLOWED.solver_timeout, {}, "model: no solution for {t}"),
        ("limited", ALLOWED.limit_time - 1, {"limits": ()}, "limits: the command stood at one for {t}"),
        (
            "limited",
            ALLOWED.limit_time - 1,
            {"limits": ("tension max",)},
            "limits: the command stood at one for {t}: tension max",
        ),
    ],
)
def test_a_run_of_bad_cycles_is_a_fault_one_cycle_after_the_longest_that_is_tolerated(
    name: str, allowed: int, more: dict[str, Any], words: str
) -> None:
    assert find_fault(SETUP, with_runs(**{name: allowed}, **more)) == ""
    expected = words.format(n=allowed + 1, t=seconds(allowed + 1))
    assert find_fault(SETUP, with_runs(**{name: allowed + 1}, **more)) == expected


@pytest.mark.parametrize(
    ("occluded", "words"), [(0, "pose stale: none accepted for {}"), (1, "occluded: the tip was not seen for {}")]
)
def test_a_pose_is_stale_after_its_time_and_an_occlusion_is_called_one(occluded: int, words: str) -> None:
    state = with_runs(occluded=occluded)
    assert find_fault(SETUP, changed(state, pose_age=ALLOWED.pose_timeout)) == ""
    age = ALLOWED.pose_timeout + 1
    assert find_fault(SETUP, changed(state, pose_age=age)) == words.format(seconds(age))


def test_no_pose_at_all_is_a_fault() -> None:
    assert find_fault(SETUP, changed(TRACKING, pose_age=None)) == "no pose"


def test_tendons_are_stale_after_their_time_if_they_have_ever_been_heard() -> None:
    age = ALLOWED.tendon_timeout + 1
    heard = changed(TRACKING, tendon_state=report(*TRACKING.tension_estimate.tolist()))
    assert find_fault(SETUP, changed(heard, tendon_age=age - 1)) == ""
    assert find_fault(SETUP, changed(heard, tendon_age=age)) == f"tendons stale: no state for {seconds(age)}"
    assert find_fault(SETUP, changed(TRACKING, tendon_state=None, tendon_age=age)) == ""


def test_what_the_tendon_driver_reports_is_a_fault() -> None:
    state = changed(TRACKING, tendon_state=report(0.0, 0.0, 0.0, 0.0, fault="servo 2: overload"))
    assert find_fault(SETUP, state) == "tendons: servo 2: overload"


def test_equal_poses_are_a_fault_only_where_the_model_has_moved() -> None:
    frozen = with_runs(equal_poses=ALLOWED.frozen_time)
    assert find_fault(SETUP, changed(frozen, path_length=FAULTS.frozen_distance)) == ""
    assert find_fault(SETUP, changed(with_runs(equal_poses=ALLOWED.frozen_time - 1), path_length=0.0234)) == ""
    assert find_fault(SETUP, changed(frozen, path_length=0.0234)) == (
        f"pose frozen: equal ones for {seconds(ALLOWED.frozen_time)} while the model's tip went 23 mm"
    )


def test_a_model_far_from_the_tip_is_a_fault_after_its_time() -> None:
    observer = dataclasses.replace(TRACKING.observer, innovation=np.array([0.12, 0.0, 0.16]))
    run = ALLOWED.mismatch_time
    assert find_fault(SETUP, changed(with_runs(mismatches=run - 1), observer=observer)) == ""
    assert find_fault(SETUP, changed(with_runs(mismatches=run), observer=observer)) == (
        f"mismatch: model and measured tip 200 mm apart, too far for {seconds(run)}"
    )


def test_a_tendon_that_does_not_pull_is_a_fault_after_its_time_and_is_named() -> None:
    tension = np.array([0.0, 30.0, 0.0, 0.0])
    state = changed(with_runs(slack=ALLOWED.slack_time), tension_estimate=tension, tendon_age=0)
    assert find_fault(SETUP, changed(state, tendon_state=report(0.0, 1.23, 0.0, 0.0))) == (
        f"tendon 1 slack: 1.2 N reported where the model has 30.0 N, for {seconds(ALLOWED.slack_time)}; is it cut, or "
        "off its spool?"
    )
    assert find_fault(SETUP, changed(state, tendon_state=report(0.0, 29.0, 0.0, 0.0))) == ""
    early = changed(with_runs(slack=ALLOWED.slack_time - 1), tension_estimate=tension, tendon_age=0)
    assert find_fault(SETUP, changed(early, tendon_state=report(0.0, 1.23, 0.0, 0.0))) == ""


@pytest.mark.parametrize(
    ("expected", "reported", "slack"),
    [
        ((0.0, 0.0, 30.0, 30.0), (0.0, 0.0, 30.0, 1.0), 3),
        ((0.0, 0.0, 30.0, 30.0), (0.0, 0.0, 1.0, 1.0), 2),
        ((FAULTS.slack_tension,) * 4, (0.0,) * 4, None),  # too little to tell
        ((30.0,) * 4, (FAULTS.slack_fraction * 30.0,) * 4, None),
        ((30.0,) * 4, (-30.0,) * 4, None),  # the wrong sign is another matter
        ((30.0,) * 4, (0.0,) * 3, None),  # another number of tendons is a fault of its own
    ],
)
def test_a_tendon_counts_as_slack_that_reports_much_less_than_the_model_has(
    expected: tuple[float, ...], reported: tuple[float, ...], slack: int | None
) -> None:
    state = changed(TRACKING, tension_estimate=np.array(expected), tendon_state=report(*reported))
    assert slack_tendon(SETUP, state) == slack
    assert slack_tendon(SETUP, changed(state, tendon_state=None)) is None


@pytest.mark.parametrize("name", ["tension_command", "tension_estimate"])
def test_a_tendon_may_pull_while_it_is_commanded_or_has_not_followed_yet(name: str) -> None:
    assert not is_taut(START)
    little = np.array([0.0, 0.0, 1e-3, 0.0])
    assert is_taut(changed(START, **{name: little}))
    assert is_taut(changed(START, release_pending=True))
