"""A calibration that is wrong, on the rod behind emulated servos: how hard the driver lets them pull, release included.

The controller here is the test, without feedback: it commands what a right calibration allows, then releases.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.schemas.config.presets import WIRED
from tests.rig.wired import WiredBench, wired_bench

pytestmark = [pytest.mark.rig, pytest.mark.sil]

TENSION_MAX = 20.0
PULL = 15.0
"""Tension of tendon 0 from which the commanded displacements are computed [N]."""

RAMP_CYCLES, HOLD_CYCLES = 100, 100
ALLOWED = 1.5 * TENSION_MAX + 15.0
"""Allowed tension [N]: servo.tension_margin, and the rise of a stiff tendon's tension until the driver has read it."""


def change(made: Calibration, index: int, **changes: Any) -> Calibration:
    """Return the calibration with one tendon changed."""
    tendons = list(made.tendons)
    tendons[index] = tendons[index].model_copy(update=changes)
    return made.model_copy(update={"tendons": tuple(tendons)})


def right(made: Calibration) -> Calibration:
    return made


def wrong_sign(made: Calibration) -> Calibration:
    return change(made, 0, sign=-1)


def half_the_radius(made: Calibration) -> Calibration:
    for index in range(4):
        made = change(made, index, spool_radius=0.0075)
    return made


def swapped(made: Calibration) -> Calibration:
    """Tendons 0 and 1 are on each other's servo."""
    return change(change(made, 0, sign=made.tendons[1].sign), 1, sign=made.tendons[0].sign)


def swapped_servos(made: Calibration) -> Calibration:
    """Exchange the servos of tendons 0 and 1 on the rig."""
    return made.model_copy(update={"tendons": (made.tendons[1], made.tendons[0], *made.tendons[2:])})


@pytest.mark.parametrize("mistake", [right, wrong_sign, half_the_radius, swapped])
def test_whatever_is_wrong_in_the_calibration_no_tendon_pulls_much_harder_than_tension_max(
    tmp_path: Path, mistake: Any
) -> None:
    text = (
        WIRED.replace("tension_max = 60.0", f"tension_max = {TENSION_MAX}")
        .replace("displacement_min = -0.08", "displacement_min = -0.035")
        .replace("displacement_max = 0.08", "displacement_max = 0.035")
        .replace("displacement_rate = 0.08", "displacement_rate = 0.04")
    )
    limits = "displacement_min = -0.035\ndisplacement_max = 0.035\n"
    with wired_bench(tmp_path, text, limits, mistake, swapped_servos if mistake is swapped else right) as bench:
        pulls, faults = _pull_and_release(bench)
        _, said = bench.end()
    print(f"{mistake.__name__}: {max(pulls):.1f} N; {faults}")
    assert "Traceback" not in said
    assert max(pulls) < ALLOWED
    assert not any(servo.energised for servo in bench.wired.bus.servos)
    if mistake is right:
        assert "while it is released" not in said
        assert faults == []
        assert max(pulls) > 0.8 * PULL


def _pull_and_release(bench: WiredBench) -> tuple[list[float], list[str]]:
    """Pull, hold, release: true tensions of all tendons [N], and the driver's last fault while armed."""
    model = bench.model
    rest = model.solve_static(np.zeros(4))
    pulled = model.solve_static(np.array([PULL, 0.0, 0.0, 0.0]))
    start, target = model.displacements(rest), model.displacements(pulled, elastic=True)
    faults: list[str] = []
    bench.await_driver(start)
    for number in range(RAMP_CYCLES + HOLD_CYCLES):
        share = min(1.0, number / RAMP_CYCLES)
        bench.cycle(start + share * (target - start), armed=True)
        if bench.fault:
            faults[:] = [bench.fault]
    for _ in range(150):
        bench.cycle(start, armed=False)
    return [tension for truth in bench.truths for tension in truth.tension], faults
