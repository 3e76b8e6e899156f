"""The drivers notify their supervisor: real processes with emulated servos and a scripted Tracker."""

import signal
import socket
import time
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.schemas.config.presets import WIRED, WIRED_SERVO, WIRED_VICON
from tests.rig.servos import calibration, emulated
from tests.rig.tracker import BASE, TIP, Tracker, free_port
from tests.sil.rig import rig
from tests.sil.supervision import PING, WATCHDOG_SECONDS, Manager

pytestmark = [pytest.mark.rig, pytest.mark.sil]


def test_a_servo_driver_is_ready_with_its_servos_and_lives_on_without_its_port(
    tmp_path: Path, manager: Manager, monkeypatch: pytest.MonkeyPatch
) -> None:
    with (
        emulated(tmp_path) as servos,
        rig(tmp_path, f'{WIRED}\n[servo]\nport = "{tmp_path}/ttyUSB0"\n{WIRED_SERVO}') as one,
    ):
        save_calibration(tmp_path / "calibration.json", calibration(rig=one.name))
        manager.in_charge(monkeypatch)
        driver = one.start("servo")
        assert manager.hear(1.0) == []  # there is no controller, so it is not ready
        monkeypatch.delenv("NOTIFY_SOCKET")
        one.controller()
        manager.await_line("READY=1")
        manager.await_line(PING)
        servos.unplug()
        manager.await_line("STATUS=fault: ")
        manager.await_line(PING, len(manager.received))  # a restart would not help: it waits for 'tendond servo reset'
        driver.send_signal(signal.SIGSTOP)
        time.sleep(0.2)
        assert manager.hear(3.0 * WATCHDOG_SECONDS) == []
        driver.send_signal(signal.SIGCONT)
        one.end(driver)
        manager.await_line("STOPPING=1")


def test_a_vicon_driver_is_ready_once_it_listens_and_reports_the_tip(
    tmp_path: Path, manager: Manager, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = free_port(socket.SOCK_DGRAM)
    with rig(tmp_path, f"[vicon]\nport = {port}\nsilence = 0.3\n{WIRED_VICON}") as one, Tracker(port) as tracker:
        one.controller()
        manager.in_charge(monkeypatch)
        driver = one.start("vicon")
        manager.await_line("READY=1")
        manager.await_line("STATUS=nothing from Tracker")
        manager.await_line(PING, len(manager.received))  # that Tracker is off is nothing that a restart fixes
        tracker.send({"tip": TIP, "base": BASE})
        manager.await_line("STATUS=no valid pose")
        assert one.end(driver)[0] == 0
        manager.await_line("STOPPING=1")
