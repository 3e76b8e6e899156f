"""A probe's pulls, number by number: when it goes on, waits, looks twice, and ends at once."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import EMPTY
from tendond.daemon.control.commissioning.probe import Probe, probe_tension
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.commissioning.verdict import Motion
from tests.unit.commissioning.blocks import (
    ALLOWED,
    BASE,
    EXPECTED,
    FIRST_LOOK,
    LAST_LOOK,
    PLAN,
    REST,
    at,
    block,
    end_block,
    report,
)


def test_what_was_pulled_harder_is_released_from_there() -> None:
    for tendon in (1, 2, 3):
        tension = probe_tension(PLAN, Probe(Phase.PULL, PLAN.down // 3, tendon, released=1.5))
        expected = np.zeros(4)
        expected[tendon - 1] = 0.75 * 1.5 * PLAN.tensions[tendon - 1]
        assert tension == pytest.approx(expected)
    last = dataclasses.replace(PLAN, tensions=np.array([1.0, 2.0, 3.0, 4.0]))
    assert probe_tension(last, Probe(Phase.RELEASE, 4, 3, released=1.5)) == pytest.approx([0.0, 0.0, 0.0, 4.5])
    assert probe_tension(last, Probe(Phase.RELEASE, 40, 3, released=1.5)) == pytest.approx([0.0] * 4)
    again = Probe(Phase.PULL, PLAN.start + PLAN.ramp // 2, 2, first=(REST, REST), released=1.5)
    assert probe_tension(PLAN, again) == pytest.approx([0.0, 0.0, 1.25 * PLAN.tensions[2], 0.0])
    assert not probe_tension(PLAN, Probe(Phase.PULL, PLAN.start - 3, 0)).any()


def pulled(tip: float, *, since: int = FIRST_LOOK, **changes: Any) -> Probe:
    """The end of a block of a pulled tendon whose tip should have moved by `EXPECTED`."""
    return end_block(BASE, at(tip), at(EXPECTED), **({"since": since - 1} | changes))


def went_on(probe: Probe) -> bool:
    return probe.tendon == 1 and len(probe.motions) == 1


def looks_twice(probe: Probe) -> bool:
    return probe.first is not None and probe.tendon == 0 and not probe.motions


def test_a_tendon_that_moves_the_tip_as_it_should_passes_with_the_first_whole_block() -> None:
    assert not went_on(pulled(EXPECTED, since=FIRST_LOOK - 1))
    passed = pulled(EXPECTED, late=block(REST, 0.0), last=at(0.0), steady=2)
    assert went_on(passed)
    assert (passed.since, passed.late, passed.last, passed.steady, passed.first, passed.released) == (
        0, EMPTY, None, 0, None, 1.0,
    )  # fmt: skip
    (motion,) = passed.motions
    assert motion.measured == pytest.approx((EXPECTED, 0.0, 0.0))
    assert motion.expected == pytest.approx((EXPECTED, 0.0, 0.0))
    assert motion.first is None


@pytest.mark.parametrize(("gain", "passes"), [(0.84, False), (0.86, True), (1.19, True), (1.21, False)])
def test_a_gain_near_one_passes_at_once_and_another_is_looked_at_twice_once_the_tip_has_settled(
    gain: float, passes: bool
) -> None:
    assert went_on(pulled(gain * EXPECTED)) is passes
    tip = at(gain * EXPECTED)
    again = pulled(gain * EXPECTED, steady=3, last=tip, late=block(REST, 0.0))
    assert looks_twice(again) is not passes
    if not passes:
        assert not looks_twice(pulled(gain * EXPECTED, steady=2, last=tip))
        assert np.array(again.first) == pytest.approx(np.array([[gain * EXPECTED, 0.0, 0.0], [EXPECTED, 0.0, 0.0]]))
        assert (again.since, again.late, again.last, again.steady) == (PLAN.start, EMPTY, None, 0)
        assert not went_on(pulled(gain * EXPECTED, since=LAST_LOOK - 1))
        assert went_on(pulled(gain * EXPECTED, since=LAST_LOOK))
        grown = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        assert went_on(pulled(gain * EXPECTED, first=grown))  # it has been looked at twice


def test_a_tip_has_settled_that_hardly_moves_in_a_block_and_since_the_one_before() -> None:
    assert went_on(pulled(EXPECTED, spread=0.99 * ALLOWED))
    assert not went_on(pulled(EXPECTED, spread=1.01 * ALLOWED))
    for apart, steady in ((0.29, 3), (0.31, 0)):
        waits = pulled(0.7 * EXPECTED, last=at(0.7 * EXPECTED + apart * ALLOWED), steady=2)
        assert waits.steady == steady
        assert waits.last == pytest.approx(at(0.7 * EXPECTED))
    assert pulled(0.7 * EXPECTED, steady=2).steady == 0
    assert pulled(0.7 * EXPECTED, last=at(0.7 * EXPECTED), steady=2, spread=1.01 * ALLOWED).steady == 0


def test_a_motion_of_the_wrong_size_is_looked_at_twice_and_one_in_a_wrong_direction_is_not() -> None:
    for tip in (0.1 * EXPECTED, 1.9 * EXPECTED):
        steady = pulled(tip, steady=3, last=at(tip))
        assert looks_twice(steady)
        assert looks_twice(pulled(tip, since=LAST_LOOK, spread=1.0))
        waits = pulled(tip, since=LAST_LOOK - 1, steady=2, last=at(tip))
        assert not went_on(waits)
        assert not looks_twice(waits)
    aside = end_block(BASE, at(0.0, EXPECTED), at(EXPECTED), since=FIRST_LOOK - 1, steady=3, last=at(0.0, EXPECTED))
    assert went_on(aside)
    assert not went_on(end_block(BASE, at(0.0, EXPECTED), at(EXPECTED), since=FIRST_LOOK - 1))


def test_a_tip_that_still_swings_at_the_end_is_judged_by_its_mean_since_half_of_the_time() -> None:
    late = block(at(0.95 * EXPECTED), 0.01, 40)
    first = ((0.001, 0.0, 0.0), (0.002, 0.0, 0.0))
    swung = pulled(0.3 * EXPECTED, since=LAST_LOOK, spread=1.0, late=late, first=first)
    assert swung.motions[0].first is None
    assert swung.motions[0].measured[0] == pytest.approx((40 * 0.95 + 0.3) / 41 * EXPECTED)
    quick = pulled(0.1 * EXPECTED, since=FIRST_LOOK, steady=3, last=at(0.1 * EXPECTED), late=late, first=first)
    assert quick.motions[0].first == first
    assert quick.motions[0].measured[0] == pytest.approx(0.1 * EXPECTED)
    half = PLAN.start + PLAN.ramp + PLAN.settling // 2
    assert pulled(EXPECTED, since=half, spread=1.0).late.count == 0
    assert pulled(EXPECTED, since=half + 1, spread=1.0).late.count == 1
    resting = end_block(Probe(Phase.REST), model_spread=1.0, since=half + 5)
    assert resting.late.count == 0


def test_after_a_second_look_the_tendon_is_released_from_more() -> None:
    first = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    passed = pulled(EXPECTED, first=first)
    assert (passed.released, passed.first) == (1.5, None)
    assert passed.motions[0].first == first


def test_after_the_last_tendon_comes_the_verdict_and_the_release() -> None:
    motions = tuple(Motion((0.0, 0.01, 0.0), (0.0, 0.01, 0.0)) for _ in range(3))
    assert pulled(EXPECTED, tendon=2, motions=motions[:2]).phase is Phase.PULL
    right = pulled(EXPECTED, tendon=3, motions=motions)
    assert (right.phase, right.verdict, len(right.motions)) == (Phase.RELEASE, "", 4)
    wrong = end_block(BASE, at(0.0, -0.9 * EXPECTED), at(EXPECTED), since=LAST_LOOK - 1, tendon=3, motions=motions)
    assert wrong.phase is Phase.RELEASE
    assert wrong.verdict.startswith("tendon 3 moves the tip 90 degrees off its direction")
    releasing = Probe(Phase.RELEASE, since=PLAN.down - 1)
    assert end_block(releasing).phase is Phase.RELEASE
    assert end_block(releasing, since=PLAN.down).phase is Phase.DONE


def test_a_motion_has_the_displacement_that_was_commanded_and_reported_since_the_rest() -> None:
    rested = ((0.001, 0.002, 0.003, 0.004), (0.01, 0.02, 0.03, 0.04))
    reported = report(displacement=(0.012, 0.0, 0.0, 0.0))
    args: dict[str, Any] = {"displacement": (0.0035, 0.0, 0.0, 0.0), "tendons": reported}

    def motion(*, since_rest: Any = rested, **changes: Any) -> Motion:
        probe = dataclasses.replace(BASE, displacement=since_rest)
        return end_block(probe, at(EXPECTED), at(EXPECTED), since=FIRST_LOOK - 1, **(args | changes)).motions[0]

    assert motion().commanded == pytest.approx(0.0025)
    assert motion().reported == pytest.approx(0.002)
    for changes in (
        {"tendons": None}, {"since_rest": (rested[0], ())}, {"tendons": report(0.0, displacement=(0.012,))},
    ):  # fmt: skip
        assert motion(**changes).commanded == pytest.approx(0.0025)
        assert motion(**changes).reported is None


def test_a_tip_may_go_further_at_the_second_look() -> None:
    first = ((0.01, 0.0, 0.0), (0.01, 0.0, 0.0))
    tip, stop = at(0.01), PLAN.stop_at
    for part, looks, done in ((0.99, None, False), (1.01, None, True), (1.49, first, False), (1.51, first, True)):
        probe = end_block(BASE, at(part * stop), tip, first=looks, since=5)
        assert (probe.phase is Phase.DONE) is done
    assert probe.verdict.startswith("tendon 0 moves the tip 39 mm where 10 mm are expected")


def test_a_motion_that_is_broken_off_is_judged_with_those_before_it() -> None:
    done = (Motion((0.01, 0.0, 0.0), (0.01, 0.0, 0.0)),)
    far = end_block(BASE, at(0.0, -0.03), at(0.0, 0.01), tendon=1, motions=done, since=5)
    assert far.phase is Phase.DONE
    assert far.verdict.startswith("tendon 1 moves the tip as tendon 3 should")
    assert far.motions[0] is done[0]
    assert far.motions[1].measured == pytest.approx((0.0, -0.03, 0.0))
    assert far.motions[1].expected == pytest.approx((0.0, 0.01, 0.0))
