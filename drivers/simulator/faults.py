"""Faults of a simulated rig, caused by a request while it runs."""

import math
from collections.abc import Callable

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.query import Queryable, replies, reply_to_next
from tendond.schemas.config.rig import RigConfig
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

    Attributes:
        time: simulated [s]; whoever steps the rig sets it.
    """

    def __init__(self, tendons: int) -> None:
        self._tendons = tendons
        self._caused: dict[tuple[Fault, int | None], tuple[FaultRequest, float]] = {}
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
        if request.fault is Fault.CLEAR:
            self._caused = {
                of: one for of, one in self._caused.items() if request.servo is not None and of[1] != request.servo
            }
            return ControlReply(done=True, message=_whose(request) + "cleared")
        lasting = request.duration
        until = math.inf if lasting is None else self.time + lasting
        self._caused[request.fault, request.servo] = request, until
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
            if fault is kind and servo is not None and self.time < until - ROUNDING
        ]

    @property
    def reported(self) -> str:
        """Fault that the servo driver reports, in words; empty without one."""
        failed = [servo for fault, servo in self._caused if fault is Fault.OVERLOAD]
        return ", ".join(f"servo {servo}: {OVERLOAD}" for servo in failed)


def _whose(request: FaultRequest) -> str:
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
