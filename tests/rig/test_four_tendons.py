"""Four tendons at once, each pretensioned against the one opposite, through the driver, the wires and emulated servos.

The controller here is the test: it knows which displacements let the tip go round in a circle with every tendon taut.
"""

import math
import time
from pathlib import Path

import numpy as np
import pytest

from tendond.drivers.dynamixel.driver.guard import limited
from tendond.schemas.config.servo import ServoSection
from tests.rig.wired import PATIENCE_SECONDS, PERIOD, WiredBench, wired_bench

pytestmark = [pytest.mark.rig, pytest.mark.sil]

TENSION_MIN, TENSION_MAX = 2.0, 8.0
"""Tension of each tendon on the circle [N]."""

TURN = 250
"""Cycles."""


def circle(cycle: int) -> np.ndarray:
    """Tensions [N], shape (4,), each tendon pulling when the circle passes its side; they rise in the first turn."""
    size = min(1.0, cycle / TURN)
    angle = 2.0 * math.pi * cycle / TURN
    sides = np.array([math.cos(angle - 0.5 * math.pi * tendon) for tendon in range(4)])
    return np.asarray(size * (TENSION_MIN + (TENSION_MAX - TENSION_MIN) * np.maximum(0.0, sides)))


def test_all_four_tendons_move_at_once_and_stay_taut_while_the_tip_circles(tmp_path: Path) -> None:
    with wired_bench(tmp_path) as bench:
        travel, taut, tip = _circle_twice(bench)
        code, said = bench.end()
    assert code == 0, said
    assert "fault: servo" not in said
    assert "fault: tendon" not in said
    assert min(travel) > 0.01  # every one of them is pulled and released
    assert min(taut) > 0.25 * TENSION_MIN  # and none of them falls slack meanwhile
    assert np.linalg.norm(tip) < 2e-3  # in the end the tip is where the model has it
    assert not any(servo.energised for servo in bench.wired.bus.servos)


def _circle_twice(bench: WiredBench) -> tuple[list[float], list[float], np.ndarray]:
    """Command two turns and a rest: travel and min tension (second turn) of each tendon, tip error."""
    model, truths = bench.model, bench.truths
    state = model.solve_static(np.zeros(4))
    bench.await_driver(model.displacements(state))
    turned = 0
    places = []
    for number in range(2 * TURN):
        if number == TURN:
            turned = len(truths)
        state = model.step(state, circle(number))
        bench.cycle(model.displacements(state, elastic=True), armed=True)
        assert bench.arrivals.tendon_state is not None
        assert bench.fault == ""
        places.append(bench.arrivals.tendon_state.displacement)
    tensions = np.array([truth.tension for truth in truths[turned:]])
    last = model.displacements(state, elastic=True)
    target = model.tip(model.solve_static(displacements=last)).position
    deadline = time.monotonic() + PATIENCE_SECONDS
    while np.linalg.norm(np.array(truths[-1].position) - target) > 1e-3 and time.monotonic() < deadline:
        bench.cycle(last, armed=True)
    return (
        np.ptp(np.array(places), axis=0).tolist(),
        tensions.min(axis=0).tolist(),
        np.array(truths[-1].position) - target,
    )


def test_tendons_that_are_too_fast_are_slowed_down_together_and_keep_their_proportion() -> None:
    section = ServoSection(period=PERIOD, displacement_rate=0.05)
    wanted, last = (0.010, -0.004, -0.010, 0.004), (0.0, 0.0, 0.0, 0.0)
    goals = limited(section, wanted, last, PERIOD)
    assert goals == pytest.approx([0.05 * one for one in wanted])
    assert limited(section, (2e-4, 0.0, 0.0, 0.0), last, PERIOD) == (2e-4, 0.0, 0.0, 0.0)
    bounded = limited(section, (1e300, -1e300, 0.0, 0.0), last, PERIOD)
    assert bounded == pytest.approx((0.0005, -0.0005, 0.0, 0.0))
