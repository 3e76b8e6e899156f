"""Sensors beside the camera with real processes: their readings reach controller, status, doctor and log."""

import json
import re
import subprocess
import sys
import time
from pathlib import Path
from statistics import median

import pytest

from tendond.offline.logs.log import load
from tendond.offline.replay.rerun import rerun
from tendond.schemas.keys import key, sensor_topic
from tendond.schemas.messages import SensorReading
from tendond.schemas.wire import encode
from tests.sil.rig import Rig, rig

pytestmark = pytest.mark.sil

SENSORS = """
[[sensors]]
name = "skin"
kind = "markers"
at = [0.2, 0.5]
offset = [0.02, 0.0, 0.0]
noise = 1e-4
delay = 0.02
timeout = 1.0
[[sensors]]
name = "imu"
kind = "imu"
noise = [0.01, 0.1]
rate = 50.0
timeout = 1.0
"""
"""The patience of `tests.sil.rig.PATIENT`, for a machine that may stand still."""


FRAMES = """
def frames():
    while True:
        yield (0.01, 0.02, 0.15), None, (0.12, 0.02, 0.43)
        time.sleep(0.05)
"""


def found_by_doctor(one: Rig) -> dict[str, str]:
    done = one.command("doctor", "--json", "--no-servos")
    (found,) = (check for check in json.loads(done.stdout)["checks"] if check["check"] == "sensors")
    return dict(found)


def test_readings_reach_status_doctor_and_log_and_silence_shows(tmp_path: Path) -> None:
    with rig(tmp_path, SENSORS) as one:
        controller, _ = one.controller(), one.start("simulate")
        with one.session() as session:
            one.arm(session)
            status = one.until(session, lambda s: all(h.rate and not h.silent for h in s.sensors.values()))
            assert list(status.sensors) == ["skin", "imu"]
            assert found_by_doctor(one)["outcome"] == "pass"
            assert "skin" in one.command("status").stdout
            stranger = SensorReading(
                seq=10**6, stamp_ns=time.monotonic_ns(), source="mine", rows=((0.0, 0.0, 0.0),) * 2
            )
            session.put(key(one.name, sensor_topic("skin")), encode(stranger))
            session.put(key(one.name, sensor_topic("skin")), b"{")
            reasons = {"sensor skin: another source", "sensor skin: malformed"}
            one.until(session, lambda s: reasons <= s.rejected.keys())
            injected = one.command("rig", "inject", "mute", "--sensor", "imu", "--seconds", "30")
            assert injected.stdout == "sensor imu: mute for 30 s\n"
            status = one.until(session, lambda s: s.sensors["imu"].silent)
            assert status.sensors["imu"].in_words.startswith("silent for ")
            assert not status.sensors["skin"].silent
            assert status.mode.value == "tracking"  # silence is no fault of a sensor that is not required
            assert "imu silent" in found_by_doctor(one)["finding"]
        assert one.end(controller)[0] == 0
    records = load(tmp_path / "run.mcap").records
    lags = [record.inputs.reading_lags["skin"] for record in records if "skin" in record.inputs.readings]
    assert median(lags) > 0.02
    outcome = rerun(tmp_path / "run.mcap")
    assert (outcome.compared, outcome.first) == (len(records), None)


def test_the_program_of_the_documentation_is_a_driver(tmp_path: Path) -> None:
    page = (Path(__file__).parents[3] / "docs" / "howto" / "sensors.md").read_text()
    (table,), (program,) = (re.findall(rf"```{kind}\n(.*?)```", page, re.DOTALL) for kind in ("toml", "python"))
    with rig(tmp_path, table) as one:
        endpoint, topic = '"tcp/127.0.0.1:7460"', '"paper/sensor/skin"'
        assert program.count(endpoint) == program.count(topic) == 1
        text = program.replace(endpoint, f'"{one.endpoint}"').replace(topic, f'"{one.name}/sensor/skin"')
        (tmp_path / "driver.py").write_text(FRAMES + text)
        one.controller()
        with one.session() as session:
            status = one.status(session)
            assert {name: health.in_words for name, health in status.sensors.items()} == dict.fromkeys(
                ("skin", "gratings", "imu"), "no reading yet"
            )
            one.processes.append(subprocess.Popen([sys.executable, "driver.py"], cwd=tmp_path, text=True))
            status = one.until(session, lambda s: s.sensors["skin"].rate is not None)
            assert not status.rejected


def test_lockstep_with_sensors_repeats_and_replays_to_the_last_bit(tmp_path: Path) -> None:
    inputs = []
    for folder in (tmp_path / "one", tmp_path / "two"):
        folder.mkdir()
        with rig(folder, SENSORS) as one:
            controller = one.controller("--lockstep", "--cycles", "120", "--arm-at", "5")
            simulator = one.start("simulate", "--lockstep", "--cycles", "120")
            assert [process.wait(120) for process in (controller, simulator)] == [0, 0]
        inputs.append([record.model_dump_json() for record in load(folder / "run.mcap").records])
    assert inputs[0] == inputs[1]
    assert sum('"imu"' in one for one in inputs[0]) == 60
    outcome = rerun(tmp_path / "one" / "run.mcap")
    assert (outcome.compared, outcome.first) == (120, None)
