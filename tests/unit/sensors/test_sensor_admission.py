"""Readings in the pure cycle: which are admitted, what is said of the others, and what silence means."""

from typing import Any

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState, followed_sources, initial_state
from tendond.daemon.runtime.status import sensor_health
from tendond.drivers.simulator.lockstep import without_probe
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, SensorReading, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import REST, SETUP, START, UPRIGHT

TEXT = """\
[commissioning]
rest = false
[[sensors]]
name = "skin"
kind = "markers"
at = [0.1, 0.2]
noise = 1e-4
delay = 0.03
[[sensors]]
name = "vehicle"
kind = "base"
noise = [1e-3, 1e-2]
timeout = 0.1
"""
SENSORS = CycleSetup.from_config(without_probe(parse_config(TEXT, "t")))
STAMPS = CycleSetup.from_config(without_probe(parse_config("[observer]\nstamps = true\n" + TEXT, "t")))
REQUIRED = CycleSetup.from_config(without_probe(parse_config(TEXT + "required = true\n", "t")))
FIRST = initial_state(SENSORS)
AT_HOME = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def skin(seq: int, *rows: tuple[float, ...] | None, source: str = "camera") -> SensorReading:
    found = rows or ((0.0, 0.0, 0.1), (0.0, 0.0, 0.2))
    return SensorReading.trusted(version=1, seq=seq, stamp_ns=0, source=source, rows=found)


def vehicle(seq: int, row: tuple[float, ...] = AT_HOME, source: str = "") -> SensorReading:
    return SensorReading.trusted(version=1, seq=seq, stamp_ns=0, source=source, rows=(row,))


class Bench:
    """The cycle, fed with poses at rest and what else is given."""

    def __init__(self, setup: CycleSetup = SENSORS) -> None:
        self.setup, self.state, self.seq = setup, initial_state(setup), 0

    def go(self, *readings: SensorReading, **inputs: Any) -> CycleRecord:
        self.seq += 1
        pose = TipPose(seq=self.seq, stamp_ns=0, position=REST, orientation=UPRIGHT)
        named = {"skin" if len(one.rows) != 1 else "vehicle": one for one in readings}
        self.state, _, record = step(self.setup, self.state, CycleInputs(pose=pose, readings=named, **inputs))
        return record

    def wait(self, cycles: int, *readings: SensorReading) -> CycleRecord:
        for _ in range(cycles):
            record = self.go(*readings)
        return record


def test_an_admitted_reading_is_in_the_state_of_its_cycle_with_name_rows_and_age() -> None:
    bench = Bench()
    assert bench.go(vehicle(3), skin(7, None, (0.0, 0.01, 0.2))).rejected == ()
    assert [(one.name, one.rows, one.age) for one in bench.state.readings] == [
        ("skin", (None, (0.0, 0.01, 0.2)), 0.03),
        ("vehicle", (AT_HOME,), 0.0),
    ]
    assert followed_sources(bench.state)["sensor/skin"] == "camera"
    bench.go()
    assert bench.state.readings == ()
    assert {name: track.age for name, track in bench.state.sensors.items()} == {"skin": 1, "vehicle": 1}
    bench.go(missed_ticks=3)
    assert bench.state.sensors["skin"].age == 5


REFUSED = {
    "another number of rows": (skin(5, (0.0, 0.0, 0.1), None, None), "skin: 3 rows, where 2 are configured"),
    "another length of a row": (
        skin(5, None, (0.0, 0.1)),
        "skin: rows that have not 3 numbers, as those of kind 'markers' do",
    ),
    "a number that is none": (skin(5, None, (0.0, float("nan"), 0.1)), "skin: not finite"),
    "the same once more": (skin(4), "skin: duplicate"),
    "an older one": (skin(2), "skin: out of order"),
    "another publisher": (skin(9, source="phone"), "skin: another source"),
    "no unit quaternion": (vehicle(9, (0.0, 0.0, 0.0, 1.0, 0.1, 0.0, 0.0)), "vehicle: bad quaternion"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_reading_that_cannot_be_used_is_dropped_and_counted_with_its_reason(case: str) -> None:
    reading, reason = REFUSED[case]
    bench = Bench()
    bench.go(skin(4), vehicle(4))
    before = bench.state
    record = bench.go(reading)
    assert record.rejected == (f"sensor {reason}",)
    assert bench.state.rejected == {f"sensor {reason}": 1}
    assert bench.state.readings == ()
    name, _, objection = reason.partition(": ")
    assert bench.state.sensors[name].objection == objection
    assert bench.state.sensors[name].seq == before.sensors[name].seq
    assert bench.go(skin(6), vehicle(10)).rejected == ()
    assert bench.state.sensors[name].objection == ""


def test_payloads_that_are_no_readings_and_further_sources_are_counted_and_touch_no_pose() -> None:
    bench = Bench()
    record = bench.go(
        skin(1), unreadable={"sensor skin: malformed": 2, "malformed": 1}, others={"sensor/vehicle": "phone"}
    )
    assert record.rejected == ("malformed", *["sensor skin: malformed"] * 2, "sensor vehicle: another source")
    assert bench.state.readings[0].name == "skin"
    assert "sensor" not in bench.state.sources.in_words()
    for _ in range(SENSORS.thresholds.rejected_time + 2):
        bench.go(unreadable={"sensor skin: malformed": 1})
    assert bench.state.bad_cycles.rejected == 0


def test_a_reading_of_an_unknown_name_is_counted() -> None:
    inputs = CycleInputs(readings={"skn": skin(1)})
    for setup, state in ((SENSORS, FIRST), (SETUP, START)):
        after, _, record = step(setup, state, inputs)
        assert record.rejected == ("sensor of an unknown name",)
        assert after.readings == ()


def test_another_source_is_taken_up_after_silence_but_never_while_tendons_are_pulled() -> None:
    idle, pulling = Bench(), Bench()
    for bench in (idle, pulling):
        bench.go(vehicle(5, source="a"))
    assert pulling.go(vehicle(6, source="a"), request=ControlAction.ARM).accepted
    timeout = SENSORS.sensors["vehicle"].timeout
    for bench in (idle, pulling):
        bench.wait(timeout)
        record = bench.go(vehicle(1, source="b"))
        assert record.rejected == (() if bench is idle else ("sensor vehicle: another source",))


def test_a_publisher_that_counts_anew_is_used_after_silence() -> None:
    bench = Bench()
    bench.go(vehicle(500))
    timeout = SENSORS.sensors["vehicle"].timeout
    assert bench.wait(timeout - 1, vehicle(3)).rejected == ("sensor vehicle: out of order",)
    assert bench.wait(2, vehicle(4)).rejected == ()
    assert bench.go(vehicle(4)).rejected == ("sensor vehicle: duplicate",)
    assert bench.state.sensors["vehicle"].seq == 4


def test_the_age_is_by_the_stamp_where_that_is_asked_for_and_of_this_hosts_clock() -> None:
    for setup, lag, age in ((SENSORS, 0.012, 0.03), (STAMPS, 0.012, 0.012), (STAMPS, -4.0, 0.03), (STAMPS, 1e6, 0.03)):
        bench = Bench(setup)
        bench.go(skin(1), reading_lags={"skin": lag})
        assert bench.state.readings[0].age == age


def test_silence_of_a_sensor_is_no_fault_unless_it_is_required() -> None:
    for setup in (SENSORS, REQUIRED):
        bench, required = Bench(setup), setup is REQUIRED
        bench.go()
        refused = bench.go(request=ControlAction.ARM)
        assert refused.accepted is not required
        if required:
            assert refused.reply == "not armed: sensor 'vehicle' silent: no reading yet"
            bench.go(vehicle(1))
            assert bench.go(vehicle(2), request=ControlAction.ARM).accepted
        record = bench.wait(setup.sensors["vehicle"].timeout)
        assert record.mode is Mode.PRETENSION
        record = bench.go()
        assert record.mode is (Mode.FAULT if required else Mode.PRETENSION)
        if required:
            assert record.reason == "sensor 'vehicle' silent: no reading for 0.11 s"


def test_the_rate_is_that_of_the_last_readings_and_silence_shows() -> None:
    bench, period = Bench(), SENSORS.config.loop.period

    def health(state: CycleState) -> Any:
        return sensor_health(SENSORS.sensors["skin"], state.sensors["skin"], period)

    assert health(bench.state).in_words == "no reading yet"
    for seq in range(20):
        bench.go(skin(seq))
        bench.wait(3)
    assert health(bench.state).rate == pytest.approx(1.0 / (4 * period))
    assert health(bench.state).in_words == "25 Hz"
    bench.wait(40)
    assert health(bench.state).in_words == "silent for 0.43 s"


def test_a_state_with_readings_survives_its_snapshot_and_one_without_sensors_has_none_in_it() -> None:
    bench = Bench()
    bench.go(skin(1, None, (0.1, 0.2, 0.3)))
    again = decode_state(CycleState, encode_state(bench.state), SENSORS)
    assert (again.readings, again.sensors) == (bench.state.readings, bench.state.sensors)
    assert "readings" not in encode_state(START)
    assert "sensors" not in encode_state(START)


def test_a_record_without_readings_does_not_speak_of_them() -> None:
    _, _, record = step(SETUP, START, CycleInputs())
    assert "reading" not in record.model_dump_json()
