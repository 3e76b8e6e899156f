"""A rig on wires in one object: emulated servos and a simulated Tracker as a thread, the drivers as processes."""

import os
import socket
import threading
import time
from contextlib import suppress
from pathlib import Path

import zenoh

from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.process import request_reset
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.wired.rig import WiredRig, without_servos
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.presets import WIRED, WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction, ControlReply
from tests.rig.servos import calibration
from tests.rig.tracker import free_port
from tests.sil.rig import Rig

PATIENCE_SECONDS = 40.0


class Chain(Rig):
    """A rig on wires, its drivers and its controller."""

    def __init__(self, folder: Path) -> None:
        port = free_port(socket.SOCK_DGRAM)
        super().__init__(
            folder,
            "[faults]\noverrun_time = 10.0\npose_timeout = 1.0\ntendon_timeout = 2.0\n"
            # a busy machine's plant lags behind, and makes up for it
            "mismatch_time = 10.0\nslack_time = 10.0\ntracking_time = 10.0\njump = 0.2\n"
            + WIRED.replace("duration = 2.5", "duration = 2.0").replace("friction = 0.1", "friction = 0.0")
            + f"\n[vicon]\nport = {port}\n{WIRED_VICON}"
            + f'\n[servo]\nport = "{folder}/ttyUSB0"\n{WIRED_SERVO}hold_time = 0.3\n',
        )
        self.ended = threading.Event()
        self.settings: RigConfig = parse_config(self.config.read_text(), "rig.toml")
        servo, vicon = self.settings.servo, self.settings.vicon
        assert servo is not None
        assert vicon is not None
        calibrated = calibration(rig=self.name)
        save_calibration(folder / "calibration.json", calibrated)
        rod = rod_from_section(self.settings.simulator.rod, self.settings.simulator.period)
        plant = Plant(without_servos(self.settings), rod)
        self.wired = WiredRig(self.settings, servo, vicon, calibrated, plant, self.ended.is_set)
        self._thread = threading.Thread(target=self._simulate)
        self._thread.start()
        self.drivers = {"servo": self.start("servo"), "vicon": self.start("vicon")}

    def _simulate(self) -> None:
        """Run robot and servos with the priority that their process has elsewhere: the drivers have it, too."""
        for thread in (threading.get_native_id(), self.wired.bus.thread_id):
            with suppress(OSError):
                os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(self.settings.loop.priority - 1))
        self.wired.run()

    def close(self) -> None:
        for process in self.processes:
            if process.poll() is None:
                process.kill()
            process.communicate()
        self.ended.set()
        self._thread.join()
        self.wired.close()

    @property
    def torques(self) -> list[bool]:
        return [servo.energised for servo in self.wired.bus.servos]

    def track(self, session: zenoh.Session, beyond: float) -> None:
        """Arm, and wait until the tip is beyond so many metres."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not (reply := self.ask(session, ControlAction.ARM)).done:
            assert time.monotonic() < deadline, reply.message
            time.sleep(0.05)
        status = self.until(
            session,
            lambda s: s.mode is Mode.FAULT or (s.mode is Mode.TRACKING and s.tip is not None and s.tip[0] > beyond),
        )
        assert status.mode is Mode.TRACKING, status.reason

    def reset_servos(self) -> ControlReply:
        """Reset the servos once the driver has released the tendons; return the reply."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not (reply := request_reset(self.settings, 30.0)).done and "being released" in reply.message:
            assert time.monotonic() < deadline, reply.message
        return reply

    def wait_for_slack_and_off(self) -> None:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while any(self.torques):
            assert time.monotonic() < deadline
            time.sleep(0.02)
        assert max(tendon.displacement for tendon in self.wired._tendons) < 0.004
