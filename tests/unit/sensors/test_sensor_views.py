"""What people are shown of sensors: in the status, in the live view, by the doctor."""

from pathlib import Path

import pytest
from rich.console import Console

from tendond.cli.doctor.check import CheckOutcome
from tendond.cli.doctor.listen import BusActivity
from tendond.cli.doctor.sensors import sensors
from tendond.cli.rig.operator import status_table
from tendond.cli.watch.screen import frame, line
from tendond.schemas.health import SensorHealth
from tendond.schemas.messages import SensorReading, Status
from tests.unit.cli.computer import Computer
from tests.unit.cli.test_watch import CONFIG, beside_the_rod, status, watched

HEALTH = {
    "skin": SensorHealth(rate=99.8, age=0.01, silent=False),
    "imu": SensorHealth(rate=50.0, age=1.234, silent=True, objection="out of order"),
}
TOLD = "skin 99.8 Hz; imu silent for 1.23 s: out of order"


def test_status_and_live_view_show_rate_or_silence_in_a_line() -> None:
    with_sensors = status().model_copy(update={"sensors": HEALTH})
    console = Console(width=200)
    with console.capture() as shown:
        console.print(status_table(with_sensors))
    assert TOLD in shown.get()
    snapshot = watched()
    snapshot.add(with_sensors, 1.9)
    assert TOLD in line(snapshot, CONFIG, 2.0)
    assert TOLD in beside_the_rod(frame(snapshot, CONFIG, 2.0, 200, 40).plain)
    sent = with_sensors.model_copy(update={"tension_estimate": (1.0,) * 4})
    assert Status.model_validate_json(sent.model_dump_json()) == sent
    assert "sensors" not in status().model_dump_json()


def readings(count: int, *rows: tuple[float, ...]) -> list[tuple[int, SensorReading]]:
    return [(i * 10_000_000, SensorReading(seq=i, stamp_ns=0, rows=rows)) for i in range(count)]


SKIN = {"name": "skin", "kind": "markers", "at": [0.1, 0.2], "noise": 1e-4}
TWO = readings(100, (0.0, 0.0, 0.1), (0.0, 0.0, 0.2))


@pytest.mark.parametrize(
    ("activity", "required", "outcome", "finding"),
    [
        (BusActivity(), False, CheckOutcome.WARN, "not checked"),
        (BusActivity(connected=True), False, CheckOutcome.WARN, "skin silent"),
        (BusActivity(connected=True), True, CheckOutcome.FAIL, "skin silent"),
        (BusActivity(connected=True, readings={"skin": TWO}), True, CheckOutcome.PASS, "skin 100 Hz"),
        (BusActivity(connected=True, readings={"skin": TWO, "skn": TWO}), False, CheckOutcome.WARN, "[[sensors]]: skn"),
        (
            BusActivity(connected=True, readings={"skin": readings(9, (0.0, 0.1))}),
            False,
            CheckOutcome.FAIL,
            "skin has 1 rows of 2 numbers, where 2 of 3 are configured",
        ),
    ],
)
def test_the_doctor_says_which_sensors_come(
    tmp_path: Path, activity: BusActivity, required: bool, outcome: CheckOutcome, finding: str
) -> None:
    computer = Computer(tmp_path)
    computer.sections = {"sensors": [{**SKIN, "required": required}]}
    rig = computer.rig
    rig.activity = activity
    result = sensors(rig)
    assert result is not None
    assert result.outcome is outcome, result
    assert finding in result.finding


def test_the_doctor_leaves_a_rig_without_sensors_alone_unless_one_is_heard(tmp_path: Path) -> None:
    rig = Computer(tmp_path).rig
    rig.activity = BusActivity(connected=True)
    assert sensors(rig) is None
    rig.activity = BusActivity(connected=True, readings={"skin": TWO})
    result = sensors(rig)
    assert result is not None
    assert result.finding == "not in [[sensors]]: skin"
