"""The servo driver's process on the rod behind emulated servos. The controller is the test."""

import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.drivers.dynamixel.calibration import Calibration, save_calibration
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.wired.rig import WiredRig, without_servos
from tendond.model.rod.rod import Rod
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.presets import WIRED, WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import SimulatorTruth, TendonCommand
from tests.rig.servos import calibration
from tests.rig.tracker import free_port
from tests.sil.background import running
from tests.sil.rig import Rig, rig

PATIENCE_SECONDS = 60.0
PERIOD = 0.01


class WiredBench:
    """Driver process and rig, cycled by the test.

    Attributes:
        wired: emulated servos and the rod. model: rod of the configuration, for the displacements to command.
        arrivals: newest messages. truths: all truths of the rod so far.
    """

    def __init__(self, one: Rig, wired: WiredRig, model: Rod, hub: Hub, driver: "subprocess.Popen[str]") -> None:
        self._rig, self._hub, self._driver = one, hub, driver
        self.wired, self.model = wired, model
        self.arrivals = Arrivals()
        self.truths: list[SimulatorTruth] = []
        self._seq = 0

    @property
    def fault(self) -> str | None:
        """Fault or objection of the driver; none before its first state."""
        state = self.arrivals.tendon_state
        return None if state is None else state.fault

    def cycle(self, displacement: np.ndarray, *, armed: bool) -> None:
        """Send a command [m], shape (n,), and receive what has come, once a period."""
        self._seq += 1
        values = tuple(np.asarray(displacement).tolist())
        zeros = (0.0,) * len(values)
        self._hub.publish_command(
            TendonCommand(seq=self._seq, stamp_ns=0, pose_seq=None, displacement=values, tension=zeros, armed=armed)
        )
        self._hub.receive(self.arrivals)
        if (truth := self.arrivals.decoded_truth()) is not None:
            self.truths.append(truth)
        time.sleep(PERIOD)

    def await_driver(self, rest: np.ndarray) -> None:
        """Send disarmed commands until the driver may be armed."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while self.fault != "":
            assert time.monotonic() < deadline, self.arrivals.tendon_state
            self.cycle(rest, armed=False)

    def end(self) -> tuple[int, str]:
        """End the driver; return its exit status and what it said."""
        return self._rig.end(self._driver)


@contextmanager
def wired_bench(
    folder: Path,
    text: str = WIRED,
    limits: str = "",
    mistake: Callable[[Calibration], Calibration] = lambda right: right,
    true: Callable[[Calibration], Calibration] = lambda right: right,
) -> Iterator[WiredBench]:
    """Start rig and driver.

    Args:
        folder: an empty one.
        text: configuration of controller and rod.
        limits: more of [servo].
        mistake: changes the calibration that the driver reads.
        true: changes the one by which the servos are mounted.
    """
    wiring = f"\n[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n{WIRED_VICON}"
    servo = f'\n[servo]\nport = "{folder}/ttyUSB0"\n{WIRED_SERVO}{limits}'
    with rig(folder, text + wiring + servo) as one:
        config = parse_config(one.config.read_text(), "rig.toml")
        assert config.servo is not None
        assert config.vicon is not None
        right = calibration(rig=one.name)
        save_calibration(folder / "calibration.json", mistake(right))
        plant = Plant(without_servos(config), rod_from_section(config.simulator.rod, PERIOD))
        ended = threading.Event()
        wired = WiredRig(config, config.servo, config.vicon, true(right), plant, ended.is_set)
        try:
            with running(wired.run, ended), Hub(config) as hub:
                yield WiredBench(one, wired, rod_from_section(config.rod, PERIOD), hub, one.start("servo"))
        finally:
            wired.close()
