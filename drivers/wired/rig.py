"""Simulated rod behind emulated servos on a pseudo-terminal and a simulated Tracker."""

import socket
import time
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import zenoh

from tendond.bus.client import StoppedError
from tendond.bus.identity import new_source
from tendond.drivers.dynamixel.calibration import Calibration, TendonCalibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.drivers.dynamixel.tools.requirements import requirements
from tendond.drivers.host import await_controller
from tendond.drivers.mocap.geometry import Alignment, Placement, euler_from_rotation, rotation_from_quaternion
from tendond.drivers.simulator.faults import handle_faults, listen
from tendond.drivers.simulator.introduction import Introduction
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.vicon.packet import Block, ObjectReading, build
from tendond.drivers.vicon.udp import MILLIMETRE
from tendond.drivers.wired.faults import cause
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.config.simulator import SimulatedServos
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.faults import Fault
from tendond.schemas.keys import SIMULATOR_TRUTH, key, sensor_topic
from tendond.schemas.messages import ENCODING, TendonCommand, TipPose
from tendond.schemas.wire import encode

HIDDEN = ObjectReading((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
RIG_PLACEMENT = Placement(np.array([1.5, -0.7, 1.1]), np.eye(3))
"""Placement of the rig in the simulated Vicon world."""

CAUGHT_UP_SECONDS = 0.1
"""Delay of the process that is made up for; beyond, the robot has stood still."""


def without_servos(config: RigConfig) -> RigConfig:
    """Return the configuration of a plant behind emulated servos, which have dynamics of their own."""
    servo = config.simulator.servo
    bare = SimulatedServos(friction=servo.friction, backlash=servo.backlash)
    return config.model_copy(update={"simulator": config.simulator.model_copy(update={"servo": bare})})


class WiredError(ConfigError):
    """The wired rig cannot be set up."""


class SpooledServo:
    """Emulated servo with a tendon of the rod on its spool; `tension` is the rod's pull [N]."""

    def __init__(self, tendon: TendonCalibration, section: ServoSection) -> None:
        self._tendon = tendon
        self.servo = EmulatedServo(tendon.servo, section.baudrate, tendon.zero, MODELS[section.model])
        for one in requirements(self.servo.model, section):  # as `tendond servo setup` leaves it
            self.servo.put(one.register, one.wanted)
        self.servo.torque = lambda ticks: -tendon.sign * self.tension * tendon.spool_radius
        self._zero = self.servo.position
        self.tension = 0.0

    @property
    def displacement(self) -> float:
        """Displacement of the tendon's end [m]."""
        return self.displacement_at(self.servo.position)

    def displacement_at(self, position: float) -> float:
        """Return the displacement of the tendon's end [m] at a position of the servo [ticks]."""
        turned = (position - self._zero) * self.servo.model.tick
        return self._tendon.sign * turned * self._tendon.spool_radius


class WiredRig:
    """Plant behind serial bus and UDP, in real time.

    A step that is late, as the computer was busy, is made up for: with the servos' positions of its own time, and a
    frame of its own number, from which the Vicon driver knows its time.

    Args:
        config: configuration of the rig; `simulator.drive` must be 'displacement'.
        servo: its [servo]; `port` is where the pseudo-terminal appears.
        vicon: its [vicon]; packets go to `port` on this computer.
        calibration: calibration of the tendons on the servos.
        plant: plant at rest.
        stopped: true when the process is to end.

    Raises:
        WiredError: the port's path is taken by something else.

    Attributes:
        bus: bus of the servos, to cause faults on.
    """

    def __init__(
        self,
        config: RigConfig,
        servo: ServoSection,
        vicon: ViconSection,
        calibration: Calibration,
        plant: Plant,
        stopped: Callable[[], bool],
    ) -> None:
        if config.simulator.drive != "displacement":
            raise WiredError("simulator.drive = 'tension': servos impose displacements; set it to 'displacement'")
        if vicon.euler_order != "XYZ":
            raise WiredError(f"vicon.euler_order = '{vicon.euler_order}': the simulated Tracker speaks 'XYZ' alone")
        if not vicon.base:
            raise WiredError("vicon.base is empty: the simulated Tracker shows the base's markers, name them")
        self._config = config
        self._vicon = vicon
        self._plant = plant
        self._introduction = Introduction(config)
        self._source = new_source("simulator")
        self._stopped = stopped
        self._alignment = Alignment(vicon, config.rod.base_gravity)
        self._tendons = [SpooledServo(tendon, servo) for tendon in calibration.tendons]
        self.bus = EmulatedBus(_free_link(Path(servo.port)), [tendon.servo for tendon in self._tendons])

    def close(self) -> None:
        """Remove the serial port."""
        self.bus.close()

    def run(self) -> None:
        """Simulate until stopped; the truth is published for the controller's log, and the readings of sensors.

        Raises:
            BusError: no controller.
            ConvergenceError: the plant has no solution.
        """
        name, period = self._config.rig.name, self._config.simulator.period
        try:
            session = await_controller(self._config, self._stopped)
        except StoppedError:
            return
        with session, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as tracker:
            topics = [SIMULATOR_TRUTH, *(sensor_topic(one.name) for one in self._config.sensors)]
            publishers = {
                topic: session.declare_publisher(key(name, topic), encoding=ENCODING, express=True) for topic in topics
            }
            faults = listen(session, name)
            deadline = time.monotonic()
            while not self._stopped():
                self._step(publishers, tracker, deadline)
                handle_faults(faults, lambda request: cause(self.bus, self._plant.faults, request))
                deadline = max(deadline + period, time.monotonic() - CAUGHT_UP_SECONDS)
                time.sleep(max(0.0, deadline - time.monotonic()))

    def _step(self, publishers: Mapping[str, zenoh.Publisher], tracker: socket.socket, at: float) -> None:
        """Advance the rod to a time [s], with the servos' displacements then, and publish the result."""
        positions = zip(self._tendons, self.bus.positions(at), strict=True)
        self._plant.step(
            TendonCommand(
                seq=self._plant.seq,
                stamp_ns=0,
                pose_seq=None,
                displacement=tuple(tendon.displacement_at(position) for tendon, position in positions),
                tension=(0.0,) * len(self._tendons),
                armed=True,  # spools hold their tendons, with torque or without
            )
        )
        pose, state, truth = self._plant.observe(round(1e9 * at))
        for tendon, tension in zip(self._tendons, state.tension, strict=True):
            tendon.tension = tension
        if self._plant.faults.now(Fault.SILENCE) is not None:
            return
        publishers[SIMULATOR_TRUTH].put(encode(self._introduction.added_to(truth).named(self._source)))
        for sensor, reading in self._plant.readings.items():
            publishers[sensor_topic(sensor)].put(encode(reading.named(self._source)))
        if pose is not None:
            tracker.sendto(self._packet(pose), ("127.0.0.1", self._vicon.port))

    def _packet(self, pose: TipPose) -> bytes:
        placement = Placement(np.array(pose.position), rotation_from_quaternion(*pose.orientation))
        tip, base = self._alignment.markers(placement)
        objects = {self._vicon.tip: _reading(tip) if pose.valid else HIDDEN}
        if self._vicon.base:
            objects[self._vicon.base] = _reading(base)
        return build(Block(pose.seq, objects))


def _reading(placement: Placement) -> ObjectReading:
    x, y, z = ((placement.position + RIG_PLACEMENT.position) / MILLIMETRE).tolist()
    return ObjectReading((x, y, z), euler_from_rotation(placement.rotation))


def _free_link(path: Path) -> Path:
    """Return a path at which nothing is, or an earlier pseudo-terminal's link.

    Raises:
        WiredError: something else is there: a real port must not be replaced by a simulated one.
    """
    ours = path.is_symlink() and str(path.readlink()).startswith("/dev/pts/")
    if path.is_relative_to("/dev") or (path.exists() and not ours):
        raise WiredError(f"servo.port = {path}: may be a real port; name a path at which nothing is")
    if not path.parent.is_dir():
        raise WiredError(f"servo.port = {path}: there is no folder {path.parent}")
    return path
