"""The tension wanted and the reference, number by number: law, ramp, probe, offset; the rod is scripted."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import Probe, probe_tension
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.cycle import step
from tendond.daemon.control.state import CycleState, changed
from tendond.daemon.control.tasks.plane import BENDING_PLANE
from tendond.model.errors import ParameterError
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tests.unit.control.phases.scripted_rod import Bench, MakeBench


def fed(one: Bench, state: CycleState, **inputs: Any) -> Any:
    return step(one.setup, state, CycleInputs(**inputs))[2].estimate


def test_a_law_on_direct_feedback_is_fed_poses_and_their_differences(bench: MakeBench) -> None:
    one = bench('[control]\nfeedback = "direct"\n')
    assert one.start.pose is None
    state = one.state(pose_age=1)
    pose = one.pose(state, 0.003, 0.0, -0.001)
    estimate = fed(one, state, pose=pose)
    assert estimate.position == pose.position
    assert estimate.velocity == pytest.approx((0.15, 0.0, -0.05))  # in two cycles of 10 ms
    first = changed(state, pose=None, pose_age=None)
    assert fed(one, first, pose=pose).velocity == (0.0, 0.0, 0.0)
    assert fed(one, state) is None


def test_a_law_on_the_observers_feedback_is_fed_the_model_and_its_offset(bench: MakeBench) -> None:
    one = bench('[observer]\nkind = "offset"\noffset_gain = 0.5\n')
    tip = replace(one.start.tip, velocity=np.array([0.3, 0.0, -0.4]), acceleration=np.array([1.0, 2.0, 3.0]))
    state = one.state(tip=tip)
    estimate = fed(one, state, pose=one.pose(state, 0.004))
    x, y, z = tip.position.tolist()
    assert estimate.position == pytest.approx((x + 0.002, y, z))
    assert estimate.velocity == (0.3, 0.0, -0.4)
    assert estimate.acceleration == (1.0, 2.0, 3.0)
    assert fed(one, state) is not None
    assert fed(one, changed(state, mode=Mode.IDLE)) is None


LAW_TEXT = """
[control]
sampled = {sampled}
plane = "{plane}"
agonist = {agonist}
{antagonist}
[limits]
input_gain_min = 0.5
[reference]
across = 0.1
[rod]
gravity = [0.0, 0.0, 0.0]
"""


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize(("plane", "agonist", "antagonist"), [("xz", 0, None), ("xz", 0, 2), ("yz", 1, 3)])
def test_the_law_asks_for_the_papers_tension_of_the_errors_in_its_plane(
    bench: MakeBench, plane: str, agonist: int, antagonist: int | None, sampled: bool
) -> None:
    """U = U_applied + b'(z1 - a1 z2 - a1^2 z1 - a2 z2 + Xd'' - a)/max(b'b, kd b'D), of the agonist's column b."""
    line = "" if antagonist is None else f"antagonist = {antagonist}\n[pretension]\nantagonist = 0.7"
    one = bench(LAW_TEXT.format(sampled=str(sampled).lower(), plane=plane, agonist=agonist, antagonist=line))
    axes = [0 if plane == "xz" else 1, 2]
    random = np.random.default_rng(5)
    tip = replace(
        one.start.tip, velocity=random.normal(size=3), acceleration=random.normal(size=3),
        input_gain=3.0 * random.normal(size=(3, 4)),
    )  # fmt: skip
    jacobian = tip.input_gain[:, agonist] * 0.004
    one.monkeypatch.setattr(one.setup.rod, "velocity_jacobian", lambda _, tendon: jacobian * (tendon == agonist))
    tension = np.array([4.0, 3.0, 2.0, 1.0])
    state = one.state(tip=tip, tension_estimate=tension, tension_command=tension, tick=20)
    record = step(one.setup, state, CycleInputs())[2]
    a1, a2 = 1500.0, 12.5
    reference = record.reference
    z1 = (np.array(reference.position) - tip.position)[axes]
    z2 = (tip.velocity - np.array(reference.velocity))[axes] - a1 * z1
    wanted = np.array(reference.acceleration)[axes] + z1 - a1 * z2 - a1**2 * z1 - a2 * z2
    b = tip.input_gain[axes, agonist]
    size = max(b @ b, (a1 + a2) * 0.004 * (b @ b)) if sampled else b @ b
    applied = tension[agonist] - (0.0 if antagonist is None else tension[antagonist])
    net = applied + b @ (wanted - tip.acceleration[axes]) / size
    expected = np.zeros(4)
    if antagonist is None:
        expected[agonist] = net
    else:
        expected[[agonist, antagonist]] = 0.7 + max(net, 0.0), 0.7 + max(-net, 0.0)
    assert record.terms["z1"] == pytest.approx(tuple(z1))
    assert record.terms["net_tension"] == pytest.approx(net)
    assert record.wanted == pytest.approx(expected)


@pytest.mark.parametrize(("text", "whole"), [
    ("", [2.0, 0.0, 0.0, 0.0]),
    ("antagonist = 0.6\n[control]\nantagonist = 2\n", [2.6, 0.0, 0.6, 0.0]),
    ('tension_min = 1.5\n[control]\nlaw = "sensitivity"\n', [1.5] * 4),
])  # fmt: skip
def test_the_pretension_is_reached_along_a_ramp_and_held(bench: MakeBench, text: str, whole: list[float]) -> None:
    one = bench(f"[limits]\ntension_rate = 1000.0\n[pretension]\ntension = 2.0\nduration = 0.2\n{text}")
    for cycles, part in ((0, 0.05), (9, 0.5), (19, 1.0)):
        state = one.state(Mode.PRETENSION, tick=30 + cycles, mode_since=30)
        assert one.go(state).state.tension_command == pytest.approx(part * np.array(whole))
    at_once = bench(f"[pretension]\ntension = 2.0\nduration = 0.0\n{text}")
    assert at_once.go(at_once.state(Mode.PRETENSION, tick=30, mode_since=30)).state.mode is Mode.TRACKING


def test_a_pretension_that_takes_no_whole_cycle_does_not_overshoot(bench: MakeBench) -> None:
    one = bench("[pretension]\ntension = 2.0\nduration = 0.015\n[limits]\ntension_rate = 1000.0\n")
    state = one.state(Mode.PRETENSION, tick=31, mode_since=30)
    assert one.go(state).state.tension_command[0] == pytest.approx(2.0)


def test_a_probe_asks_for_its_tensions_within_limits_of_its_own(bench: MakeBench) -> None:
    one = bench("[commissioning]\ntension_fraction = 0.1\n[limits]\ntension_min = 0.4\n", probe=True)
    plan = one.setup.probe
    probe = Probe(
        Phase.PULL, since=plan.start + plan.ramp // 2, base=(0.0, 0.0, 0.5), model_base=(0.0, 0.0, 0.5),
        displacement=((0.0,) * 4, ()),
    )  # fmt: skip
    wanted = probe_tension(plan, replace(probe, since=probe.since + 1))
    near = np.maximum(wanted - 0.01, 0.0)
    response = one.go(one.state(Mode.PROBE, probe=probe, tension_command=near, tension_estimate=near))
    assert response.state.tension_command == pytest.approx(wanted)
    assert 0.0 < wanted[0] < plan.tensions[0]
    high = np.array([50.0, 0.0, 0.0, 0.0])
    capped = one.go(one.state(Mode.PROBE, probe=probe, tension_command=high, tension_estimate=high))
    assert capped.state.tension_command[0] == pytest.approx(6.0)  # a tenth of 60 N
    assert "tension max" in capped.limited


def test_past_its_target_an_arm_is_held_by_the_targets_tension(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_rate = 1e5\n[control]\nantagonist = 2\n")
    angle = math.radians(205.0)  # it rests at 165
    over = np.array(
        [[math.cos(angle), 0.0, math.sin(angle)], [0.0, 1.0, 0.0], [-math.sin(angle), 0.0, math.cos(angle)]]
    )
    tip = replace(one.start.tip, rotation=over)
    held = np.array([20.0, 0.0, 5.0, 0.0])
    state = one.state(tip=tip, tension_estimate=held, tension_command=held)
    command = one.go(state).state.tension_command
    statics = one.setup.rod.tip(one.setup.rod.solve_static(command))
    assert statics.position[0] == pytest.approx(0.34, abs=1e-3)  # the target of the paper
    assert command[1:].tolist() == [0.0, 0.0, 0.0]
    direct = bench('[limits]\ntension_rate = 1e5\n[control]\nantagonist = 2\nfeedback = "direct"\n')
    over_direct = direct.state(tip=tip, tension_estimate=held, tension_command=held)
    response = direct.go(over_direct, pose=direct.pose(over_direct))
    assert response.decision is not None
    assert response.state.tension_command != pytest.approx(command, abs=0.1)


def test_the_reference_is_offset_along_the_straight_rod(bench: MakeBench) -> None:
    one = bench()
    plain, moved = (one.go(one.state(tick=900, reference_offset=offset)).reference for offset in (0.0, 0.02))
    assert np.subtract(moved.position, plain.position) == pytest.approx([0.0, 0.0, 0.02])


def resting(one: Bench, across: float, along: float, elapsed: int = 1000, **changes: Any) -> CycleState:
    """Tracking for long, with the tip beside the reference's end [m], and the tension held."""
    state = one.state(tick=elapsed, **changes)
    target = one.go(state).reference.position
    x, y, z = np.array(target) + np.array([across, 0.0, along])
    return changed(state, tip=replace(state.tip, position=np.array([x, y, z])))


def test_a_reference_across_follows_a_load_along_where_the_tip_has_arrived(bench: MakeBench) -> None:
    """Follow by 0.4 of the difference each cycle, no further than 8 % of the length: 40 mm."""
    one = bench("[limits]\ntension_rate = 1e9\ntension_max = 500.0\n")

    def offset(across: float, along: float, before: float = 0.0, **changes: Any) -> float:
        state = resting(one, across, along, reference_offset=before, **changes)
        response = one.go(state)
        assert response.limited in ((), ("tension min",)), response.limited
        return response.state.reference_offset

    assert offset(0.0, 0.01) == pytest.approx(0.004)
    assert offset(0.0, -0.01) == pytest.approx(-0.004)
    assert offset(0.0, 0.01, 0.02) == pytest.approx(0.024)
    assert offset(-0.0339, 0.01) == pytest.approx(0.004)  # within a tenth of 0.34 m
    assert offset(-0.0341, 0.01) == 0.0
    assert offset(-0.0341, 0.01, 0.02) == 0.02
    assert offset(0.0, 0.01, 0.039) == pytest.approx(0.04)
    assert offset(0.0, -0.01, -0.039) == pytest.approx(-0.04)
    assert offset(0.0, 0.01, 0.02, mode=Mode.RELEASING) == 0.0
    assert offset(0.0, 0.01, 0.02, mode_since=1000) == 0.02  # not there yet


def test_a_reference_does_not_follow_a_load_where_a_limit_holds_the_tip_back_or_the_place_was_asked_for(
    bench: MakeBench,
) -> None:
    one = bench("[limits]\ntension_rate = 1.0\n")
    state = resting(one, -0.02, 0.01, reference_offset=0.02)
    response = one.go(state)
    assert "tension rate" in response.limited
    assert response.state.reference_offset == 0.02
    place = bench('[reference]\nposition = [0.2, 0.0, 0.4]\nunreachable = "track"\n[limits]\ntension_rate = 1e9\n')
    fixed = place.go(resting(place, 0.0, 0.001))
    assert fixed.state.reference_offset == 0.0


def test_a_task_in_the_plane_is_made_of_the_configuration_and_refuses_a_reference_in_space(bench: MakeBench) -> None:
    one = bench(
        "[loop]\nperiod = 0.02\n[control]\nantagonist = 2\n[pretension]\ntension = 2.0\nantagonist = 0.6\n"
        "[limits]\ninput_gain_min = 0.7\n"
    )
    config, reference = one.setup.config, one.setup.selection.task.reference
    task = BENDING_PLANE.task(config, one.setup.rod.parameters, reference)
    assert (task.tendon_count, task.tension, task.pair_tension, task.input_gain_min) == (4, 2.0, 0.6, 0.7)
    assert (task.period, task.control, task.reference) == (0.02, config.control, reference)
    assert BENDING_PLANE.follows(config.reference)
    space = bench('[control]\nlaw = "sensitivity"\n[reference]\nkind = "circle"\n').setup
    assert not BENDING_PLANE.follows(space.config.reference)
    with pytest.raises(ParameterError, match=r"^the reference is in space, where one of the bending plane is needed$"):
        BENDING_PLANE.task(space.config, space.rod.parameters, space.selection.task.reference)
