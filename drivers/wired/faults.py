"""Faults of the rig on wires, caused by a request while it runs."""

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.session import BusError, open_client
from tendond.schemas.config import RigConfig
from tendond.schemas.keys import SIMULATOR_FAULT, key
from tendond.schemas.messages import ENCODING, ControlReply, WiredFault, WiredFaultRequest
from tendond.schemas.wire import UnreadableError, decode, encode

ANSWER_SECONDS = 2.0
HOT = 75.0
"""[degree Celsius]: above the servos' own limit."""

OVERLOAD_BIT = 5
CORRUPT_ANSWERS = 20


def cause(bus: EmulatedBus, request: WiredFaultRequest) -> ControlReply:
    """Cause a fault, or mend it; the answer says which servo has it."""
    if request.fault is WiredFault.UNPLUG:
        bus.unplug()
        return ControlReply(done=True, message="unplugged")
    if request.fault is WiredFault.PLUG:
        bus.plug()
        return ControlReply(done=True, message="plugged in")
    if request.fault is WiredFault.CRC:
        bus.corrupt = CORRUPT_ANSWERS
        return ControlReply(done=True, message=f"the next {CORRUPT_ANSWERS} answers have a wrong CRC")
    servo = next((one for one in bus.servos if one.id == request.servo), None)
    if servo is None:
        known = ", ".join(str(one.id) for one in bus.servos)
        return ControlReply(done=False, message=f"there is no servo {request.servo}; the servos are {known}")

    def change() -> None:
        match request.fault:
            case WiredFault.SILENT:
                servo.silent = True
            case WiredFault.STUCK:
                servo.stuck = True
            case WiredFault.HOT:
                servo.temperature = HOT
            case WiredFault.OVERLOAD:
                servo.fail(OVERLOAD_BIT)
            case WiredFault.REBOOT:
                servo.power_up()
            case WiredFault.MEND:
                servo.silent = servo.stuck = False
                servo.temperature = 30.0
                servo.power_up()

    bus.tell(change)
    return ControlReply(done=True, message=f"servo {request.servo}: {request.fault.value}")


def request_fault(config: RigConfig, request: WiredFaultRequest, timeout: float = 1.0) -> ControlReply:
    """Ask a running rig on wires for a fault.

    Raises:
        BusError: there is no controller, or no rig on wires.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        replies = session.get(
            key(config.rig.name, SIMULATOR_FAULT), payload=encode(request), encoding=ENCODING, timeout=ANSWER_SECONDS
        )
        for reply in replies:
            if reply.ok is not None:
                try:
                    return decode(ControlReply, reply.ok.payload.to_bytes())
                except UnreadableError as error:
                    raise BusError(f"the rig's answer is {error.reason}") from None
    raise BusError(f"no rig on wires answers as '{config.rig.name}': start it with 'tendond simulate --wired'")
