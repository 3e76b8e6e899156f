"""The doctor at real rigs: a controller, emulated servos on a pseudo-terminal, poses from a scripted Tracker."""

import json
import math
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from tendond.cli.doctor import camera
from tendond.cli.doctor import servos as servo_checks
from tendond.cli.doctor.check import CheckOutcome, CheckResult
from tendond.cli.doctor.check import Rig as DoctorRig
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.emulator.protocol import Instruction
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.vicon.packet import ObjectReading
from tendond.schemas.config.presets import WIRED, WIRED_SERVO
from tendond.schemas.config.rig import check_config, parse_config
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose
from tendond.schemas.requests import ControlAction
from tendond.schemas.wire import encode
from tests.rig.servos import calibration, emulated
from tests.rig.tracker import BASE, TIP, Tracker, free_port
from tests.sil.background import running
from tests.sil.rig import Rig, rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

ASKING = {Instruction.PING, Instruction.READ, Instruction.SYNC_READ, Instruction.FAST_SYNC_READ}


def servo_rig(folder: Path) -> str:
    return f'{WIRED}\n[servo]\nport = "{folder}/ttyUSB0"\n{WIRED_SERVO}'


def examined(one: Rig, *arguments: str) -> tuple[int, dict[str, dict[str, str]], "subprocess.CompletedProcess[str]"]:
    """Run the doctor; return its exit status, and the results by check."""
    result = one.command("doctor", "--json", *arguments)
    assert "Traceback" not in result.stderr
    report: dict[str, Any] = json.loads(result.stdout)
    return result.returncode, {line["check"]: line for line in report["checks"]}, result


REST, TURNED = (-0.02767, 0.0, 0.49912), (math.cos(0.03692), 0.0, -math.sin(0.03692), 0.0)
"""The paper's robot at rest under its own weight: tip [m], and its quaternion."""


@contextmanager
def poses_at(one: Rig, hertz: float) -> Iterator[None]:
    """Publish poses as a driver does."""
    ending = threading.Event()

    def publish() -> None:
        seq = 0
        with one.session() as session:
            while not ending.wait(1.0 / hertz):
                seq += 1
                pose = TipPose(seq=seq, stamp_ns=time.monotonic_ns(), position=REST, orientation=TURNED)
                session.put(key(one.name, TIP_POSE), encode(pose))

    with running(publish, ending):
        yield


def test_a_rig_from_its_first_start_to_a_running_driver(tmp_path: Path) -> None:
    with rig(tmp_path, servo_rig(tmp_path)) as one:
        code, found, result = examined(one)
        assert code == 1
        assert {name for name, line in found.items() if line["outcome"] == "fail"} == {"servo port", "calibration"}
        assert "calibrate" in found["calibration"]["remedy"]
        assert "is free" in found["controller"]["finding"]
        assert "servos" not in found  # there is no port to ask them through
        assert result.stderr.count("\n") == 1

        save_calibration(tmp_path / "calibration.json", calibration(rig=one.name))
        with emulated(tmp_path) as servos:
            code, found, _ = examined(one)
            assert code == 0, found
            assert found["servos"]["outcome"] == "pass"
            assert "XL430-W250-T, firmware 46, 12.0 V, 30 degrees" in found["servos"]["finding"]
            assert {packet.instruction for packet in servos.instructions} <= ASKING  # nothing was written
            assert not any(servo.energised for servo in servos.servos)

            one.controller()
            driver = one.start("servo")
            with one.session() as session, poses_at(one, 100.0):
                one.status(session)
                while "servo driver" not in found or found["servo driver"]["outcome"] != "pass":
                    assert driver.poll() is None
                    code, found, _ = examined(one)
                assert found["controller"]["outcome"] == "pass"
                assert " Hz, " in found["poses"]["finding"]
                assert found["servos"]["finding"] == "not queried: in use by the driver"
                assert one.ask(session, ControlAction.STATUS).done


def checked(one: Rig) -> CheckResult:
    """Return the doctor's result for the servos alone, on a rig without processes."""
    config = parse_config(one.config.read_text(), "rig.toml")
    result = servo_checks.servos(DoctorRig(config, one.config, one.folder))
    assert result is not None
    return result


def test_servos_with_something_wrong_are_named_with_the_remedy(tmp_path: Path) -> None:
    with rig(tmp_path, servo_rig(tmp_path)) as one, emulated(tmp_path) as servos:
        save_calibration(tmp_path / "calibration.json", calibration(rig=one.name))
        servos.servos[1].fail(5)
        _, found, _ = examined(one)
        assert found["servos"]["outcome"] == "fail"
        assert "servo 2" in found["servos"]["finding"]
        assert "Overload" in found["servos"]["finding"]
        servos.apply(servos.servos[1].power_up)
        servos.apply(lambda: servos.servos[2]._store(table.SHUTDOWN, 0))
        result = checked(one)
        assert "servo 3" in result.finding
        assert "Shutdown is 0, must be 52" in result.finding
        assert result.remedy == "tendond servo setup 3"
        servos.apply(lambda: servos.servos[0]._store(table.STATUS_RETURN_LEVEL, 0))
        assert "servo 1 replies only to pings: its Status Return Level is 0" in checked(one).finding
        servos.apply(lambda: servos.servos[0]._store(table.STATUS_RETURN_LEVEL, 2))
        servos.instructions.clear()
        _, found, _ = examined(one, "--no-servos")
        assert "servos" not in found
        assert not servos.instructions


def test_poses_too_seldom_and_another_rig_on_the_same_endpoint(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        one.controller()
        with one.session() as session, poses_at(one, 20.0):
            one.status(session)
            code, found, _ = examined(one)
            assert code == 0
            assert found["poses"]["outcome"] == "warn"
            one.config.write_text(one.config.read_text().replace('"sil"', '"other"'))
            code, found, _ = examined(one)
            assert code == 1
            assert "no controller of rig 'other' replies" in found["controller"]["finding"]


def test_a_wrong_configuration_and_a_wrong_option(tmp_path: Path) -> None:
    with rig(tmp_path, "[rod]\nlenght = 1\nradius = -1\n") as one:
        code, found, result = examined(one)
        assert (code, list(found)) == (2, ["configuration"])
        assert "lenght" in found["configuration"]["finding"]
        assert "radius" in found["configuration"]["finding"]
        assert result.stderr.count("\n") == 1
        assert one.command("doctor", "--nonsense").returncode == 2


def test_the_text_report_is_plain_in_a_pipe(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        said = one.command("doctor").stdout
        assert "\033" not in said
        assert all(line.startswith(("pass  ", "warn  ", "fail  ", "      ")) for line in said.splitlines())
        assert table.MODEL_NAME not in said


@pytest.mark.parametrize(
    ("roll", "expected", "finding"),
    [
        (3.0, CheckOutcome.WARN, "the base is turned by 3.0 degrees against gravity"),
        (-9.0, CheckOutcome.FAIL, "set rod.gravity = [-9.69, 1.53, 0.00]"),
        (1.0, CheckOutcome.PASS, "the base is within 2 degrees of rod.gravity: 1.0"),
        (None, CheckOutcome.WARN, "no pose of 'base' arrived"),
    ],
)
def test_a_base_that_is_tilted_against_gravity_is_reported_with_the_gravity_that_would_fit(
    tmp_path: Path, roll: float | None, expected: CheckOutcome, finding: str
) -> None:
    with camera_rig(tmp_path) as (one, port), frames_to(port, roll):
        result = camera.level(one)
    assert result is not None
    assert (result.outcome, finding in result.finding) == (expected, True), result


def test_a_base_cannot_be_measured_beside_a_running_driver_and_the_result_says_so(tmp_path: Path) -> None:
    with camera_rig(tmp_path) as (one, port), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as driver:
        driver.bind(("127.0.0.1", port))
        result = camera.level(one)
    assert result is not None
    assert result.outcome is CheckOutcome.WARN
    assert "is another driver running" in result.finding
    assert "stop the driver" in result.remedy


@contextmanager
def camera_rig(folder: Path) -> Iterator[tuple[DoctorRig, int]]:
    """Yield the robot, its base object's +x along the rod's -z, so that a roll about x tilts it; and Tracker's port."""
    port = free_port(socket.SOCK_DGRAM)
    section = {"base_axes": ["+z", "+y", "-x"], "gravity_tolerance": 0.1, "port": port, "address": "127.0.0.1"}
    yield DoctorRig(check_config({"vicon": section}, "test"), None, folder), port


@contextmanager
def frames_to(port: int, roll: float | None) -> Iterator[None]:
    """Tracker's frames with the base rolled by an angle [degrees], or without the base."""
    ending = threading.Event()
    objects = {"tip": TIP}
    if roll is not None:
        objects["base"] = ObjectReading(BASE.translation, (math.radians(roll), 0.0, 0.0))

    def send() -> None:
        with Tracker(port) as tracker:
            while not ending.wait(0.005):
                tracker.send(objects)

    with running(send, ending):
        yield
