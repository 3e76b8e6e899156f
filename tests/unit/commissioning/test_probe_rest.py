"""A probe's plan and its rest, number by number: when it begins, waits, gives up, or ends at once."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.averages import EMPTY, RESTLESS, RestWatch
from tendond.daemon.control.commissioning.probe import Probe, start_probe
from tendond.daemon.control.commissioning.probe_advance import advance_probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.commissioning.rotations import rotation_matrix
from tendond.schemas.messages import TipPose
from tests.unit.commissioning.blocks import BASE, LEVEL, PLAN, REST, STILL, at, block, end_block, plan, report
from tests.unit.commissioning.rest.rests import FAMILY, as_quaternion, rest


def test_a_plan_follows_from_the_rod_the_tendons_and_the_period() -> None:
    """A tendon at distance r bends the rod by T r / EI, and its tip goes T r L^2 / 2 EI; 12 N are allowed."""
    one = plan()
    stiffness, motion = 190e9 * math.pi * 1e-3**4 / 4.0, 0.01
    wanted = 2.0 * stiffness * motion / (0.02 * 0.25)
    assert one.tensions == pytest.approx([2.0 * wanted, wanted, wanted, wanted])
    assert (one.motion, one.length, one.stop_at, one.load_max) == pytest.approx((motion, 0.5, 0.026, 12.0))
    assert one.slack == pytest.approx(2.0 * 2.0 * motion * 0.02 / 0.5)
    assert one.rate == pytest.approx(one.slack / 0.4)
    assert (one.down, one.start, one.ramp, one.block, one.rest, one.settling) == (12, 16, 20, 10, 50, 100)
    assert dataclasses.astuple(one.bounds) == (0.4, 0.5, 1.6, 0.05 * 0.02)
    assert [arm.tolist() for arm in one.arms] == [
        [0.01, 0.0, 0.0],
        [0.0, 0.02, 0.0],
        [-0.02, 0.0, 0.0],
        [0.0, -0.02, 0.0],
    ]
    assert one.rests is None
    slow = plan(0.1, 0.1, 0.3)
    assert (slow.down, slow.start, slow.ramp, slow.block, slow.rest, slow.settling) == (1, 2, 1, 2, 5, 3)


def test_a_probe_starts_with_the_base_that_the_rest_shows() -> None:
    position, rotation = rest(tilt=np.radians([0.0, 1.0, 0.0]), offset=np.array([0.001, 0.0, 0.0]))
    watch = RESTLESS
    for _ in range(5):
        watch = watch.add(tuple(position.tolist()), as_quaternion(rotation), 25)
    held = (0.001, 0.002, 0.003, 0.004)
    probe = start_probe(FAMILY, watch, held, only=True)
    assert watch.best is not None
    fit = FAMILY.fit(watch.best.mean, rotation_matrix(watch.best.mean_orientation))
    assert (probe.only, probe.held) == (True, held)
    assert probe.start == pytest.approx(tuple(position))
    assert probe.tilt == tuple(fit.tilt.tolist())
    assert probe.offset == tuple(fit.offset.tolist())
    assert probe.start is not None
    assert probe.in_base(probe.start) == pytest.approx(tuple(fit.position), abs=2e-4)
    for one in (start_probe(None, watch, held, only=False), start_probe(FAMILY, RESTLESS, held, only=False)):
        assert (one.start, one.held, one.only, one.tilt, one.offset) == (None, held, False, (0.0,) * 3, (0.0,) * 3)
    assert start_probe(None, watch, only=True).only
    assert start_probe(FAMILY, watch, only=False).held is None


def test_a_position_in_the_bases_frame_is_displaced_and_turned_back() -> None:
    probe = Probe(tilt=(0.0, 0.0, math.pi / 2.0), offset=(0.1, 0.0, 0.0))
    assert probe.in_base((0.1, 0.2, 0.3)) == pytest.approx((0.2, 0.0, 0.3))


def test_a_block_ends_with_its_number_of_cycles_and_two_poses() -> None:
    one = Probe(Phase.REST, measured=block(REST, 0.0, 0), model=block(REST, 0.0, PLAN.block + 5))
    pose = TipPose(seq=1, stamp_ns=0, position=REST, orientation=LEVEL)
    first = advance_probe(PLAN, one, pose, np.array(REST), STILL, None, np.zeros(4))
    assert (first.measured.count, first.model.count) == (1, PLAN.block + 6)
    without = advance_probe(PLAN, first, None, np.array(REST), STILL, None, np.zeros(4))
    assert (without.measured.count, without.model.count) == (1, PLAN.block + 7)
    second = advance_probe(PLAN, without, pose, np.array(REST), STILL, None, np.zeros(4))
    assert (second.measured, second.model, second.since) == (EMPTY, EMPTY, 3)
    short = Probe(Phase.REST, measured=block(REST, 0.0, 5), model=block(REST, 0.0, PLAN.block - 2))
    assert advance_probe(PLAN, short, pose, np.array(REST), STILL, None, np.zeros(4)).model.count == PLAN.block - 1


RESTED: dict[str, Any] = {"since": PLAN.rest - 1}


def test_the_first_pull_begins_from_the_means_of_the_rest() -> None:
    begun = end_block(
        Probe(Phase.REST), REST, at(0.001), tendons=report(displacement=(0.1, 0.2, 0.3, 0.4)),
        displacement=(0.5, 0.6, 0.7, 0.8), **RESTED,
    )  # fmt: skip
    assert (begun.phase, begun.since, begun.tendon) == (Phase.PULL, 0, 0)
    assert begun.base == pytest.approx(REST)
    assert begun.model_base == pytest.approx(at(0.001))
    assert begun.displacement == ((0.5, 0.6, 0.7, 0.8), (0.1, 0.2, 0.3, 0.4))
    assert end_block(Probe(Phase.REST), **RESTED).displacement == ((0.0,) * 4, ())
    assert end_block(Probe(Phase.REST), since=PLAN.rest - 2).phase is Phase.REST


@pytest.mark.parametrize(
    ("changes", "begins"),
    [
        ({"model_spread": 0.99e-3}, True),  # 0.002 of the length
        ({"model_spread": 1.01e-3}, False),
        ({"model": at(1.99e-3)}, True),  # 0.004 of it
        ({"model": at(2.01e-3)}, False),
        ({"model": at(2.01e-3), "since": PLAN.rest + PLAN.settling - 2}, False),
        ({"model": at(2.01e-3), "since": PLAN.rest + PLAN.settling - 1}, True),  # one that cannot come nearer
        ({"model": at(3.0e-3), "offset": (-0.002, 0.0, 0.0)}, True),
        ({"watch": RestWatch(5, block(REST, 0.0), None)}, False),
        ({"watch": RestWatch(5, block(at(0.006), 0.0), block(REST, 0.0))}, False),  # it moves
        ({"watch": RestWatch(5, block(at(0.004), 0.0), block(REST, 0.0))}, True),
    ],
)
def test_the_first_pull_waits_for_a_tip_and_a_model_that_rest_together(changes: Any, begins: bool) -> None:
    probe = end_block(Probe(Phase.REST), **(RESTED | changes))
    assert (probe.phase is Phase.PULL) is begins
    assert probe.verdict == ""


def test_an_arm_that_does_not_come_to_rest_is_given_up() -> None:
    last = PLAN.rest + 2 * PLAN.settling
    assert end_block(Probe(Phase.REST), model_spread=1.0, since=last - 2).phase is Phase.REST
    given_up = end_block(Probe(Phase.REST), model_spread=1.0, since=last - 1)
    assert given_up.phase is Phase.DONE
    assert given_up.verdict == "the arm does not come to rest: is it blown at, or touched?"


def test_a_rest_that_has_become_a_wrong_one_is_named_before_the_first_pull() -> None:
    wrong = end_block(Probe(Phase.REST), use=dataclasses.replace(PLAN, rests=FAMILY), **RESTED)
    assert wrong.phase is Phase.DONE
    assert wrong.verdict.startswith("the arm does not rest as the model does: tip at (-30, 0, 500) mm")
    position, rotation = rest()
    x, y, z = position.tolist()
    right = RESTLESS
    for _ in range(20):
        right = right.add((x, y, z), as_quaternion(rotation), 10)
    begun = end_block(
        Probe(Phase.REST), (x, y, z), (x, y, z), watch=right, use=dataclasses.replace(PLAN, rests=FAMILY), **RESTED
    )
    assert begun.phase is Phase.PULL


def test_a_load_while_all_tendons_are_released_is_a_reversed_spool() -> None:
    """0.6 of the probe's largest tension, 12 N."""
    assert end_block(Probe(Phase.REST), tendons=report(0.0, 7.19, 0.0, 0.0)).phase is Phase.REST
    stopped = end_block(Probe(Phase.REST), tendons=report(0.0, 7.21, 0.0, 0.0))
    assert (stopped.phase, stopped.motions) == (Phase.DONE, ())
    assert stopped.verdict.startswith("tendon 1 reports 7.2 N while all are ")
    assert stopped.verdict.endswith(" the wrong way round?")
    assert end_block(BASE, tendons=report(0.0, 11.9, 0.0, 0.0)).phase is Phase.PULL
    silent = advance_probe(PLAN, BASE, None, np.array(REST), STILL, report(0.0, 12.1, 0.0, 0.0), np.zeros(4))
    assert (silent.phase, silent.motions) == (Phase.DONE, ())
    assert silent.verdict == (
        f"tendon 1 reports 12.1 N while tendon 0 is pulled with {PLAN.tensions[0]:.1f} N: is the servo's calibration "
        "right?"
    )


def test_a_tip_that_moves_while_all_tendons_are_released_ends_the_probe() -> None:
    """0.02 of the length: 10 mm."""
    resting = Probe(Phase.REST, start=REST)
    assert end_block(resting, at(0.0099)).phase is Phase.REST
    stopped = end_block(resting, at(0.0101))
    assert stopped.phase is Phase.DONE
    assert stopped.verdict.startswith("the tip moves 10 mm while all tendons are ")
    assert stopped.verdict.endswith("the wrong way round?")
    assert end_block(dataclasses.replace(BASE, start=REST), at(0.0101)).phase is Phase.PULL
    assert end_block(Probe(Phase.REST), at(0.0101)).phase is Phase.REST


def test_a_tip_that_a_tendon_still_held_may_go_home_while_it_is_released() -> None:
    use = dataclasses.replace(PLAN, rests=FAMILY)
    home = use.slack_rest
    assert home is not None
    np.testing.assert_allclose(home, rest()[0], atol=2e-3 * PLAN.length)  # the nearest of the grid

    def beside(x: float) -> tuple[float, float, float]:
        return (home[0] + x, home[1], home[2])

    held = Probe(Phase.REST, start=beside(0.015))
    for end, phase in ((0.003, Phase.REST), (-0.014, Phase.REST), (-0.016, Phase.DONE), (0.026, Phase.DONE)):
        assert end_block(held, beside(end), use=use).phase is phase, end
