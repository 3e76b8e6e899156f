"""The probe, number by number: how it pulls, when it goes on, looks twice, judges and ends."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import EMPTY, RestWatch
from tendond.daemon.control.commissioning.probe import Probe, probe_tension
from tendond.daemon.control.commissioning.probe_advance import advance_probe
from tendond.daemon.control.commissioning.probe_plan import Phase, ProbePlan, probe_limits
from tendond.daemon.control.commissioning.verdict import Motion
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import TendonState, TipPose

LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)
MOTION: Vector3 = (0.01, 0.0, 0.0)
MOTIONS: list[Vector3] = [(0.01, 0.0, 0.0), (0.0, 0.01, 0.0), (-0.01, 0.0, 0.0), (0.0, -0.01, 0.0)]


def plan(text: str = "") -> tuple[RigConfig, ProbePlan]:
    config = parse_config(text, "test")
    return config, ProbePlan.from_config(config, rod_from_section(config.rod, config.loop.period).parameters, None)


CONFIG, PLAN = plan()
REST: Vector3 = (-0.03, 0.0, 0.5)


def test_a_probe_pulls_by_the_rods_stiffness_and_no_more_than_its_part_of_the_largest_tension() -> None:
    """A tendon at r bends the rod by T r / EI: its tip goes T r L^2 / 2 EI."""
    section = CONFIG.commissioning
    stiffness = 190e9 * math.pi * 1e-3**4 / 4.0
    wanted = 2.0 * stiffness * section.motion * 0.5 / (0.02 * 0.5**2)
    largest = section.tension_fraction * 60.0
    assert wanted < largest
    assert PLAN.tensions == pytest.approx([wanted] * 4)
    assert PLAN.load_max == pytest.approx(largest)
    assert PLAN.stop_at == pytest.approx(2.6 * section.motion * 0.5)
    assert PLAN.slack == pytest.approx(2.0 * 2.0 * section.motion * 0.02)
    assert PLAN.rate == pytest.approx(PLAN.slack / 0.4)
    assert (PLAN.down, PLAN.start, PLAN.block, PLAN.rest) == (12, 16, 10, 50)
    assert (PLAN.ramp, PLAN.settling) == (round(section.ramp / 0.01), round(section.settling / 0.01))
    _, stiff = plan("[rod]\nyoungs_modulus = 1e12\n[limits]\ntension_max = 30.0\n[reference]\nacross = 0.01\n")
    assert stiff.tensions == pytest.approx([section.tension_fraction * 30.0 / 1.5] * 4)  # half as much again is allowed
    limits = probe_limits(CONFIG)
    assert limits.tension_min == 0.0
    assert limits.tension_max == pytest.approx(largest)


@pytest.mark.parametrize(
    ("tendon", "since", "parts"),
    [
        (0, 0, {}),
        (0, PLAN.start, {}),
        (0, PLAN.start + PLAN.ramp / 2, {0: 0.5}),
        (0, PLAN.start + PLAN.ramp / 3, {0: 0.25}),
        (0, PLAN.start + PLAN.ramp, {0: 1.0}),
        (0, PLAN.start + 10 * PLAN.ramp, {0: 1.0}),
        (2, 0, {1: 1.0}),
        (2, PLAN.down / 3, {1: 0.75}),
        (2, PLAN.down, {}),
        (2, PLAN.start + PLAN.ramp, {2: 1.0}),
    ],
)
def test_a_tendon_is_pulled_along_half_a_cosine_after_the_one_before_it_is_let_go(
    tendon: int, since: Any, parts: dict[int, float]
) -> None:
    expected = [parts.get(i, 0.0) * PLAN.tensions[i] for i in range(4)]
    assert probe_tension(PLAN, Probe(Phase.PULL, since, tendon)) == pytest.approx(expected, abs=1e-12)


def test_nothing_is_pulled_at_rest_and_the_last_tendon_is_let_go_at_the_end() -> None:
    for phase in (Phase.REST, Phase.DONE):
        assert not probe_tension(PLAN, Probe(phase, 5)).any()
    released = probe_tension(PLAN, Probe(Phase.RELEASE, PLAN.down // 3, 3))
    assert released == pytest.approx([0.0, 0.0, 0.0, 0.75 * PLAN.tensions[3]])


class Stand:
    """A probe whose measured tip and reports the test says, a cycle after the other."""

    def __init__(self, probe: Probe, plan: ProbePlan = PLAN) -> None:
        self.probe, self.plan = probe, plan
        self.seq = 0

    def go(self, tip: Vector3 = REST, model: Vector3 = REST, tension: tuple[float, ...] | None = None) -> Probe:
        self.seq += 1
        pose = TipPose(seq=self.seq, stamp_ns=0, position=tip, orientation=LEVEL)
        state = (
            None if tension is None else TendonState(seq=self.seq, stamp_ns=0, displacement=(0.0,) * 4, tension=tension)
        )
        still = RestWatch(5, EMPTY.add(REST, LEVEL), EMPTY.add(REST, LEVEL))
        self.probe = advance_probe(self.plan, self.probe, pose, np.array(model), still, state, np.zeros(4))
        return self.probe


def beyond(x: float) -> Vector3:
    return (REST[0] + x, REST[1], REST[2])


PULLED = Probe(Phase.PULL, base=REST, model_base=REST, displacement=((0.0,) * 4, ()))


def test_a_probe_begins_once_tip_and_model_rest_and_the_time_has_passed() -> None:
    stand = Stand(Probe())
    phases = [stand.go().phase for _ in range(PLAN.rest)]
    assert phases == [Phase.REST] * (PLAN.rest - 1) + [Phase.PULL]
    assert (stand.probe.since, stand.probe.tendon) == (0, 0)
    assert stand.probe.base == pytest.approx(REST)
    assert stand.probe.model_base == pytest.approx(REST)


def test_a_model_that_still_moves_is_waited_for_and_not_for_ever() -> None:
    stand = Stand(Probe())
    for k in range(PLAN.rest + 2 * PLAN.settling + PLAN.block):
        probe = stand.go(model=beyond(0.002 * (k % 2)))
        if probe.phase is Phase.DONE:
            break
    assert probe.verdict == "the arm does not come to rest: is it blown at, or touched?"
    assert PLAN.rest + 2 * PLAN.settling <= stand.seq <= PLAN.rest + 2 * PLAN.settling + PLAN.block


def test_a_tendon_that_moves_the_tip_as_it_should_is_followed_by_the_next_and_the_last_by_the_release() -> None:
    stand = Stand(PULLED)
    cycles = []
    for tendon in range(4):
        before = stand.seq
        assert stand.probe.tendon == tendon
        while len(stand.probe.motions) == tendon:
            stand.go(beyond(0.011), beyond(0.01))
        cycles.append(stand.seq - before)
    assert all(PLAN.start + PLAN.ramp + PLAN.block <= n < PLAN.start + PLAN.ramp + 2 * PLAN.block for n in cycles)
    assert stand.probe.phase is Phase.RELEASE
    assert stand.probe.verdict == ""
    assert [motion.gain for motion in stand.probe.motions] == pytest.approx([1.1] * 4)
    for _ in range(PLAN.down):
        assert stand.go().phase is Phase.RELEASE
    assert stand.go().phase is Phase.DONE


def test_a_tendon_that_does_not_move_the_tip_is_pulled_half_as_much_again_before_it_is_named() -> None:
    stand = Stand(dataclasses.replace(PULLED, tendon=3, motions=(Motion(MOTION, MOTION),) * 3))
    pulled = []
    while len(stand.probe.motions) == 3:
        stand.go(beyond(0.001), beyond(0.01))
        pulled.append(probe_tension(PLAN, stand.probe)[3])
    assert max(pulled[: PLAN.start + PLAN.ramp + PLAN.block]) == pytest.approx(PLAN.tensions[3])
    assert max(pulled) == pytest.approx(1.5 * PLAN.tensions[3])
    assert stand.seq <= 2 * (PLAN.start + PLAN.ramp + PLAN.settling + PLAN.block)
    assert stand.probe.motions[3].size == pytest.approx(0.1)
    assert stand.probe.verdict.startswith("tendon 3 does not move the tip (1.0 of 10.0 mm)")


@pytest.mark.parametrize(("growth", "verdict"), [(0.01, ""), (0.025, "tendon 3 moves the tip 2.5 times as far")])
def test_a_motion_of_the_wrong_size_is_judged_by_what_more_tension_adds(growth: float, verdict: str) -> None:
    """The tip is 5 mm short at the first tension: slack was taken up, or the spool is small."""
    stand = Stand(dataclasses.replace(PULLED, tendon=3, motions=tuple(Motion(one, one) for one in MOTIONS[1:])))
    while len(stand.probe.motions) == 3:
        part = probe_tension(PLAN, stand.probe)[3] / PLAN.tensions[3]
        more = part - 1.0 if stand.probe.first is not None else 0.0
        stand.go(beyond(0.007 + growth * more), beyond(0.01 + 0.01 * more))
    assert stand.probe.motions[3].gain == pytest.approx(growth / 0.01, rel=0.05)
    assert stand.probe.verdict.startswith(verdict)
    assert bool(stand.probe.verdict) == bool(verdict)


def test_a_tip_that_still_swings_is_judged_by_its_mean_over_the_second_half_of_the_time() -> None:
    stand = Stand(dataclasses.replace(PULLED, tendon=3, motions=(Motion(MOTION, MOTION),) * 3))
    while len(stand.probe.motions) == 3:
        early = stand.seq < PLAN.start + PLAN.ramp + PLAN.settling // 2
        swing = 0.012 * math.sin(2.0 * math.pi * stand.seq / 23.0)
        stand.go(beyond((0.014 if early else 0.01) + swing), beyond(0.01))
    assert stand.probe.motions[3].size == pytest.approx(1.0, abs=0.15)
    assert stand.probe.verdict == ""


def test_a_tip_that_goes_much_further_than_asked_for_ends_the_probe_at_once() -> None:
    stand = Stand(PULLED)
    assert stand.go(beyond(0.99 * PLAN.stop_at), beyond(0.01)).phase is Phase.PULL
    assert stand.go(beyond(1.01 * PLAN.stop_at), beyond(0.01)).phase is Phase.DONE
    moved, expected = 1.01 * PLAN.stop_at * 1e3, PLAN.motion * 1e3
    assert stand.probe.verdict == (
        f"tendon 0 moves the tip {moved:.0f} mm where {expected:.0f} mm are expected: is the spool's radius, or the "
        "rod's stiffness, right?"
    )


def test_a_tip_that_moves_as_for_another_tendon_is_named_when_the_probe_is_broken_off() -> None:
    probe = Stand(PULLED).go((REST[0], REST[1] + 1.01 * PLAN.stop_at, REST[2]), beyond(0.01))
    assert probe.phase is Phase.DONE
    assert probe.verdict.startswith("tendon 0 moves the tip as tendon 1 should")


def test_a_load_far_beyond_what_the_probe_pulls_with_ends_it_at_once() -> None:
    stand = Stand(PULLED)
    assert stand.go(tension=(0.0, 0.0, 0.99 * PLAN.load_max, 0.0)).phase is Phase.PULL
    assert stand.go(tension=(0.0, 0.0, 1.01 * PLAN.load_max, 0.0)).phase is Phase.DONE
    assert stand.probe.verdict == (
        f"tendon 2 reports {1.01 * PLAN.load_max:.1f} N while tendon 0 is pulled with {PLAN.tensions[0]:.1f} N: is the "
        "servo's calibration right?"
    )
