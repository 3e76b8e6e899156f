"""The model's step while tendons are probed."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import TAKE_UP, Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.schemas.messages import Mode
from tests.unit.control.phases.scripted_rod import Bench, MakeBench

FAST = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n"
LAG = "[observer]\nlag = 0.02\n"
LAG_FACTOR = math.exp(-0.5)  # of a step after a cycle of 10 ms


def tendons(*values: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([*values, *[0.0] * (4 - len(values))])


def probing(one: Bench, probe: Probe, **changes: Any) -> Any:
    return one.go(one.state(Mode.PROBE, probe=probe, **changes)).state


@pytest.mark.parametrize("lag", ["", LAG])
def test_a_probe_begins_at_the_reported_displacement_and_only_releases(bench: MakeBench, lag: str) -> None:
    one = bench(f"[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n{lag}", probe=True)
    slow, lag_factor = one.setup.probe.rate * one.period, LAG_FACTOR if lag else 0.0
    one.rod.base = tendons(0.004, -0.004)
    held = (0.003, 0.003, -0.01, 0.0)
    first = probing(one, Probe(Phase.REST, held=held))
    expected = np.array(held) - slow
    assert first.displacement_command == pytest.approx(expected)
    assert first.displacement_estimate == pytest.approx(expected + lag_factor * (np.array(held) - expected))
    last = tendons(0.001, 0.001)
    second = probing(one, Probe(Phase.REST, since=1, held=held), displacement_command=last)
    assert second.displacement_command == pytest.approx(last + np.array([slow, -slow, -slow, -slow]))
    without = probing(one, Probe(Phase.REST))
    assert without.displacement_command == pytest.approx(one.rod.base - slow)


def test_a_probe_releases_what_is_not_pulled_by_its_own_slack_or_a_larger_configured_one(bench: MakeBench) -> None:
    one = bench(FAST, probe=True)
    slack, slow = one.setup.probe.slack, one.setup.probe.rate * one.period
    near = np.full(4, -slack + 0.5 * slow)
    rested = probing(one, Probe(Phase.REST, since=5), displacement_command=near)
    assert rested.displacement_command == pytest.approx([-slack] * 4)
    wide = bench(f"{FAST}slack = 0.04\n", probe=True)
    rested = probing(wide, Probe(Phase.REST, since=5), displacement_command=np.full(4, -0.04 + 0.5 * slow))
    assert rested.displacement_command == pytest.approx([-0.04] * 4)


def test_a_probed_tendon_is_taken_up_slowly_and_released_at_the_displacements_rate(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_rate = 1e5\ndisplacement_rate = 0.3\n", probe=True)
    slow = one.setup.probe.rate * one.period
    one.rod.base = tendons(0.02, -0.02)
    probe = Probe(
        Phase.PULL, since=one.setup.probe.start + one.setup.probe.ramp, base=(0.0, 0.0, 0.5),
        model_base=(0.0, 0.0, 0.5), displacement=((0.0,) * 4, ()),
    )  # fmt: skip
    after = probing(one, probe, tension_command=one.setup.probe.tensions * tendons(1.0), tension_estimate=tendons(0.5))
    assert after.displacement_command[:2] == pytest.approx([TAKE_UP * slow, -0.003])
