"""Metrics know what a simulator injected: they end before it, and each recovery is measured."""

from pathlib import Path

import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.offline.logs.injections import Injection, injections, recoveries, within
from tendond.offline.logs.log import load
from tendond.offline.logs.metrics import SETTLED, metrics, runs, tracking
from tendond.offline.logs.summary import summary
from tendond.offline.paper.published import published_for
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.offline.figures.logs import approach, idle, truth, write_simulated
from tests.unit.offline.records import cycle_record

PUSHED = """\
[rod]
nodes = 6
[simulator.rod]
nodes = 6
[commissioning]
probe = false
[[simulator.impacts]]
time = 1.0
duration = 0.05
force = [2.0, 0.0, 0.0]
[simulator.weight]
mass = 0.02
time = 1.4
"""


def pushed(settled: int = 40) -> list[CycleRecord]:
    """A run that settles at 0.34 m, is pushed to 0.5 m for 5 cycles, and comes back 10 cycles later."""
    records = approach(10, settled)
    at = 10 + settled
    records += [cycle_record(at + i, (0.5, 0.0, 0.1), displacement=0.05) for i in range(15)]
    return idle(0, 10) + records + [cycle_record(at + 15 + i, (0.34, 0.0, 0.05)) for i in range(20)]


def test_an_injection_lasts_from_the_first_to_the_last_cycle_with_its_name() -> None:
    said = [truth(0), truth(1, "impact"), truth(2, "impact", "noise"), truth(3, "noise"), truth(4), truth(5, "weight")]
    assert injections(range(10, 16), said) == [
        Injection("impact", 11, 13),
        Injection("noise", 12, 14),
        Injection("weight", 15, None),
    ]


def test_only_what_begins_within_a_run_counts_and_is_counted_from_its_start() -> None:
    found = [Injection("weight", 3, None), Injection("impact", 12, 14), Injection("noise", 15, 99)]
    assert within(found, 10, 20) == (Injection("impact", 2, 4), Injection("noise", 5, None))


def test_an_impact_is_no_overshoot_and_settling_is_before_it(tmp_path: Path) -> None:
    calm = load(write_simulated(tmp_path / "calm.mcap", idle(0, 10) + approach(10, 40)))
    log = load(write_simulated(tmp_path / "pushed.mcap", pushed(), {50 + i: "impact" for i in range(5)}))
    alone, disturbed = metrics(tracking(calm)), metrics(tracking(log))
    assert disturbed.overshoot_percent == alone.overshoot_percent == 0.0
    assert disturbed.settling_iterations == alone.settling_iterations
    without = load(write_simulated(tmp_path / "unknown.mcap", pushed()))
    assert metrics(tracking(without)).overshoot_percent > 40.0


def test_the_recovery_is_the_time_until_the_tip_is_back_in_the_band(tmp_path: Path) -> None:
    log = load(write_simulated(tmp_path / "a.mcap", pushed(), {50 + i: "impact" for i in range(5)}))
    run = tracking(log)
    (one,) = recoveries(run, SETTLED, metrics(run).settling_iterations)
    assert one.what == "impact"
    assert (one.time_s, one.recovery_s) == pytest.approx((0.4, 0.15))
    assert one.deviation_mm > 160.0
    assert summary(log)["recoveries"][0]["recovery_s"] == pytest.approx(0.15)


def test_a_tip_that_does_not_come_back_has_no_recovery_and_one_that_never_left_has_none_to_make(tmp_path: Path) -> None:
    gone = load(write_simulated(tmp_path / "gone.mcap", pushed()[:60], {50: "impact"}))
    assert summary(gone)["recoveries"][0]["recovery_s"] is None
    stays = load(write_simulated(tmp_path / "stays.mcap", idle(0, 10) + approach(10, 60), {50: "impact"}))
    assert summary(stays)["recoveries"][0]["recovery_s"] == 0.0


def test_the_end_of_a_weight_that_lasts_is_a_disturbance_of_its_own(tmp_path: Path) -> None:
    settled = 60
    lasting = {70 + i: "weight" for i in range(30)}
    records = pushed(settled) + [cycle_record(105 + i, (0.34, 0.0, 0.05)) for i in range(20)]
    log = load(write_simulated(tmp_path / "a.mcap", records, lasting))
    assert [one["what"] for one in summary(log)["recoveries"]] == ["weight", "weight ends"]


def test_a_simulated_run_says_what_was_injected_into_it(tmp_path: Path) -> None:
    config = parse_config(PUSHED, "pushed")
    record_lockstep(CycleSetup.from_config(config), 180, {5: ControlAction.ARM}, tmp_path / "run.mcap")
    log = load(tmp_path / "run.mcap")
    (run,) = runs(log)
    assert [(one.what, None if one.end is None else one.end - one.start) for one in run.injections] == [
        ("impact", 5),
        ("weight", None),
    ]
    start = int(run.ticks[0]) + run.injections[0].start
    assert 0 <= start - 100 <= 2  # the simulated time of the push, and the step that shows it


def test_the_papers_numbers_are_shown_only_beside_its_own_task_and_robot(tmp_path: Path) -> None:
    def found(name: str, injected: dict[int, str] | None = None, **sections: object) -> bool:
        config = RigConfig.model_validate(sections)
        records = idle(0, 10) + approach(10, 40)
        return published_for(load(write_simulated(tmp_path / f"{name}.mcap", records, injected, config))) is not None

    assert found("same")
    assert found("nodes", rod={"nodes": 50})
    assert not found("shorter", rod={"length": 0.4})
    assert not found("heavier", rod={"density": 8000.0})
    assert not found("slower", reference={"kind": "minimum_jerk"})
    assert not found("weight", simulator={"weight": {"mass": 0.05}})
    assert not found("pushed", {30: "impact"})
    assert not found("plant", simulator={"rod": {"youngs_modulus": 1e11}})
