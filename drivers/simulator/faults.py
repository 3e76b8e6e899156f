"""Faults of a simulated rig, caused by a request while it runs."""

import math
from collections.abc import Callable, Sequence

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.query import Queryable, replies, reply_to_next
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.sensors.section import SensorSection
from tendond.schemas.faults import FAULTS, Fault, FaultRequest
from tendond.schemas.keys import SIMULATOR_INJECT, key
from tendond.schemas.requests import ControlReply
from tendond.schemas.wire import UnreadableError, decode, encode

REPLY_SECONDS = 2.0
ROUNDING = 1e-9
"""Rounding of simulated time [s]."""

OVERLOAD = "Overload Error (bit 5)"
"""Text of the servo driver for an overload."""


class Faults:
    """Faults of a simulated rig at its present time.

    Args:
        tendons: number of tendons, and of servos.
        sensors: those beside the camera.

    Attributes:
        time: simulated [s]; whoever steps the rig sets it.
    """

    def __init__(self, tendons: int, sensors: Sequence[SensorSection] = ()) -> None:
        self._tendons = tendons
        self._sensors = {one.name: one for one in sensors}
        self._caused: dict[tuple[Fault, int | str | None], tuple[FaultRequest, float]] = {}
        self.time = 0.0

    def cause(self, request: FaultRequest) -> ControlReply:
        """Cause a fault from now on, or clear faults; the reply says what was done, or why not."""
        if FAULTS[request.fault].wires:
            return ControlReply(
                done=False, message=f"{request.fault.value} needs wires: start the rig with 'tendond simulate --wired'"
            )
        if request.servo is not None and not 1 <= request.servo <= self._tendons:
            return ControlReply(
                done=False, message=f"there is no servo {request.servo}; the servos are 1 to {self._tendons}"
            )
        if request.sensor is not None and (wrong := self._misfit(request.sensor, request)):
            return ControlReply(done=False, message=wrong)
        if request.fault is Fault.CLEAR:
            self._caused = {
                of: one for of, one in self._caused.items() if request.servo is not None and of[1] != request.servo
            }
            return ControlReply(done=True, message=_whose(request) + "cleared")
        lasting = request.duration
        until = math.inf if lasting is None else self.time + lasting
        self._caused[request.fault, request.servo or request.sensor] = request, until
        span = "until it is cleared" if lasting is None else f"for {lasting:g} s"
        kind = FAULTS[request.fault]
        size = f" of {request.amount:g} {kind.unit}" if kind.size is not None else ""
        return ControlReply(done=True, message=f"{_whose(request)}{request.fault.value}{size} {span}")

    def now(self, fault: Fault) -> FaultRequest | None:
        """Return the request of a fault that is active now, if any."""
        for (kind, _), (request, until) in self._caused.items():
            if kind is fault and self.time < until - ROUNDING:
                return request
        return None

    def of_sensor(self, fault: Fault, name: str) -> FaultRequest | None:
        """Return the request of a fault of a sensor that is active now, if any."""
        request, until = self._caused.get((fault, name), (None, self.time))
        return request if self.time < until - ROUNDING else None

    def _misfit(self, name: str, request: FaultRequest) -> str:
        """Say why a sensor cannot have this fault; empty where it can."""
        sensor = self._sensors.get(name)
        if sensor is None:
            known = ", ".join(self._sensors) or "none"
            return f"there is no sensor '{name}'; [[sensors]] of the simulator's configuration has: {known}"
        needed = max(request.rows or ((0, 1) if request.fault is Fault.SWAPPED else (0,)))
        return (
            "" if needed < sensor.rows else f"sensor '{name}' has no row {needed}; its rows are 0 to {sensor.rows - 1}"
        )

    @property
    def active(self) -> set[str]:
        """Names of the faults that are active now."""
        return {fault.value for (fault, _), (_, until) in self._caused.items() if self.time < until - ROUNDING}

    @property
    def stuck(self) -> list[int]:
        """Indices of the tendons whose servos do not move."""
        return self._tendons_with(Fault.STUCK)

    @property
    def cut(self) -> list[int]:
        """Indices of the tendons that do not pull."""
        return self._tendons_with(Fault.CUT)

    def _tendons_with(self, kind: Fault) -> list[int]:
        return [
            servo - 1
            for (fault, servo), (_, until) in self._caused.items()
            if fault is kind and isinstance(servo, int) and self.time < until - ROUNDING
        ]

    @property
    def reported(self) -> str:
        """Fault that the servo driver reports, in words; empty without one."""
        failed = [servo for fault, servo in self._caused if fault is Fault.OVERLOAD]
        return ", ".join(f"servo {servo}: {OVERLOAD}" for servo in failed)


def _whose(request: FaultRequest) -> str:
    if request.sensor is not None:
        return f"sensor {request.sensor}: "
    return "" if request.servo is None else f"servo {request.servo}: "


def listen(session: zenoh.Session, rig: str) -> Queryable:
    """Declare the queryable for requests."""
    return session.declare_queryable(key(rig, SIMULATOR_INJECT), zenoh.handlers.RingChannel(8))


def handle_faults(requests: Queryable, cause: Callable[[FaultRequest], ControlReply]) -> None:
    """Cause the fault of the next request, if there is one; never waits."""

    def reply_to(payload: bytes | None) -> ControlReply:
        try:
            return cause(decode(FaultRequest, payload or b""))
        except UnreadableError as error:
            return ControlReply(done=False, message=f"the request is {error.reason}")

    reply_to_next(requests, reply_to)


def request_fault(config: RigConfig, request: FaultRequest, timeout: float = 1.0) -> ControlReply:
    """Ask a running simulator for a fault.

    Raises:
        BusError: there is no controller, or no simulator.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        expression = key(config.rig.name, SIMULATOR_INJECT)
        for reply in replies(session, expression, encode(request), REPLY_SECONDS, "simulator"):
            return reply
    raise BusError(f"no simulator replies as '{config.rig.name}': start it with 'tendond simulate'")
