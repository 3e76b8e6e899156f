"""The estimate of a cycle, number by number: observer, jumps, mismatches, slack tendons; the rod is scripted."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.jump import JumpWatch
from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.state import BadCycles, CycleState, changed
from tendond.schemas.messages import Mode, TendonState
from tests.unit.control.phases.scripted_rod import Bench, MakeBench

PULLING = np.array([2.0, 0.0, 0.0, 0.0])


def test_the_observer_takes_a_pose_that_is_new_and_coasts_without_one(bench: MakeBench) -> None:
    one = bench()
    state = one.state()
    seen = one.go(state, pose=one.pose(state, 0.004, -0.002, 0.001)).state.observer
    assert seen.innovation == pytest.approx([0.004, -0.002, 0.001])
    assert any(seen.pull)
    coasting = one.go(changed(state, observer=seen)).state.observer
    assert coasting.innovation == pytest.approx([0.004, -0.002, 0.001])
    assert not any(coasting.pull)


def probe_after(one: Bench, state: CycleState, **inputs: Any) -> Probe:
    probe = one.go(state, **inputs).state.probe
    assert probe is not None
    return probe


def test_in_the_probe_the_observer_sees_the_tip_in_the_bases_frame_and_nothing_while_a_tendon_is_pulled(
    bench: MakeBench,
) -> None:
    one = bench(probe=True)
    resting = one.state(Mode.PROBE, probe=Probe(Phase.REST, offset=(0.001, 0.002, -0.003)))
    innovation = one.go(resting, pose=one.pose(resting)).state.observer.innovation
    assert innovation == pytest.approx([-0.001, -0.002, 0.003])
    pulled = Probe(Phase.PULL, base=(0.0, 0.0, 0.5), model_base=(0.0, 0.0, 0.5), displacement=((0.0,) * 4, ()))
    pulling = one.state(Mode.PROBE, probe=pulled)
    response = one.go(pulling, pose=one.pose(pulling, 0.004))
    assert not any(response.state.observer.innovation)
    assert response.state.bad_cycles.mismatches == 0
    assert response.state.probe is not None
    assert response.state.probe.measured.count == 1
    assert probe_after(one, pulling).measured.count == 0


def test_a_probe_reads_a_new_report_of_the_tendons_only(bench: MakeBench) -> None:
    one = bench(probe=True)
    state = one.state(Mode.PROBE, probe=Probe(Phase.REST))
    heavy = TendonState(seq=1, stamp_ns=0, tension=(0.0, 0.0, 20.0, 0.0), displacement=(0.0,) * 4)
    assert probe_after(one, state, tendon_state=heavy).verdict.startswith("tendon 2 reports")
    old = changed(state, tendon_state=heavy, tendon_age=0)
    assert probe_after(one, old).verdict == ""
    assert one.go(changed(state, mode=Mode.TRACKING)).state.probe is state.probe


def test_an_admitted_pose_is_watched_by_its_age_and_against_the_reference_and_a_refused_one_is_not(
    bench: MakeBench,
) -> None:
    one = bench()
    state = one.state()
    pose = one.pose(state, 0.003).model_copy(update={"stamp_ns": 5})
    seen = one.go(state, pose=pose, pose_lag=0.03)
    assert seen.state.stamp_age.seconds == 0.03
    assert seen.state.tracking_watch.error == pytest.approx(math.dist(pose.position, seen.reference.position))
    old = one.go(state, pose=pose.model_copy(update={"seq": 1}), pose_lag=0.03)
    assert old.rejected == ("out of order",)
    assert old.state.stamp_age == state.stamp_age
    assert old.state.tracking_watch == state.tracking_watch


def test_the_path_of_the_models_tip_is_its_speed_times_the_period(bench: MakeBench) -> None:
    one = bench()
    tip = replace(one.start.tip, velocity=np.array([0.3, 0.0, -0.4]))
    assert one.go(one.state(tip=tip, path_length=0.02)).state.path_length == pytest.approx(0.025)


def test_a_mismatch_is_an_innovation_beyond_its_part_of_the_length_and_counts_from_pose_to_pose(
    bench: MakeBench,
) -> None:
    one = bench("[faults]\nmismatch = 0.1\n[rod]\nlength = 0.4\n[reference]\nacross = 0.1\n")
    state = one.state(Mode.RELEASING, tension_command=PULLING, pose_age=2)  # the next pose is the third cycle after
    for size, before, after in ((0.0401, 0, 1), (0.0399, 0, 0), (0.0401, 4, 7), (0.0399, 4, 0)):
        bad = BadCycles(mismatches=before)
        pose = one.pose(state, 0.6 * size, 0.8 * size)
        assert one.go(changed(state, bad_cycles=bad), pose=pose).state.bad_cycles.mismatches == after
    assert one.go(changed(state, bad_cycles=BadCycles(mismatches=4))).state.bad_cycles.mismatches == 4


def test_a_slack_tendon_counts_from_report_to_report_while_active(bench: MakeBench) -> None:
    one = bench("[faults]\nslack_tension = 1.0\nslack_fraction = 0.2\n")
    reports = {
        load: TendonState(seq=9, stamp_ns=0, tension=(load, 0.0, 0.0, 0.0), displacement=(0.0,) * 4)
        for load in (0.3, 0.5)
    }
    state = one.state(
        tension_estimate=PULLING, tension_command=PULLING, tendon_age=2,
        tendon_state=reports[0.5].model_copy(update={"seq": 8}),
    )  # fmt: skip
    for load, before, after in ((0.3, 0, 1), (0.5, 0, 0), (0.3, 4, 7), (0.5, 4, 0)):
        bad = BadCycles(slack=before)
        assert one.go(changed(state, bad_cycles=bad), tendon_state=reports[load]).state.bad_cycles.slack == after
    counting = changed(state, bad_cycles=BadCycles(slack=4))
    assert one.go(counting).state.bad_cycles.slack == 4  # an old report says nothing
    releasing = changed(counting, mode=Mode.RELEASING)
    assert one.go(releasing, tendon_state=reports[0.3]).state.bad_cycles.slack == 0


def test_a_pose_that_jumps_is_withheld_from_observer_and_law(bench: MakeBench) -> None:
    one = bench('[control]\nfeedback = "direct"\n')
    x, y, z = one.start.tip.position.tolist()
    state = one.state(previous_position=np.array([x, y, z]))
    assert one.go(state, pose=one.pose(state, 0.001)).decision is not None
    jumped = one.go(state, pose=one.pose(state, 0.08))
    assert jumped.state.jump_watch.withheld
    assert jumped.decision is None
    assert not any(jumped.state.observer.innovation)
    assert jumped.state.bad_cycles.mismatches == 0
    assert np.array_equal(jumped.state.tension_command, state.tension_estimate)


@pytest.mark.parametrize(("feedback", "runs"), [("direct", False), ("observer", True)])
def test_a_pose_that_is_not_believed_yet_does_not_feed_a_law_on_direct_feedback(
    bench: MakeBench, feedback: str, runs: bool
) -> None:
    one = bench(f'[control]\nfeedback = "{feedback}"\n')
    x, y, z = one.start.tip.position.tolist()
    jump = JumpWatch(origin=(x, y, z - 0.003), step_size=0.003, rested=1)
    state = one.state(previous_position=np.array([x, y, z]), jump_watch=jump)
    response = one.go(state, pose=one.pose(state, 0.001))
    assert response.state.jump_watch.pose_distrusted
    assert not response.state.jump_watch.withheld
    assert response.state.observer.innovation[0] == pytest.approx(0.001)  # the model is held to it
    assert (response.decision is not None) is runs
