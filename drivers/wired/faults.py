"""Faults of the rig on wires, caused by a request while it runs: servos and bus here, the rest as in any other."""

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.simulator.faults import Faults
from tendond.schemas.faults import FAULTS, Fault, FaultRequest
from tendond.schemas.requests import ControlReply

HOT = 75.0
"""Temperature above the servos' own limit [degree Celsius]."""

LOW_VOLTS = 3.0
OVERLOAD_BIT = 5
CORRUPT_REPLIES = 20


def cause(bus: EmulatedBus, others: Faults, request: FaultRequest) -> ControlReply:
    """Cause or clear a fault; the reply names the servo.

    Args:
        bus: bus of the servos.
        others: faults of camera and arm.
        request: what is asked for.
    """
    kind = FAULTS[request.fault]
    if request.fault is Fault.UNPLUG:
        bus.unplug()
        return ControlReply(done=True, message="unplugged")
    if request.fault is Fault.PLUG:
        bus.plug()
        return ControlReply(done=True, message="plugged in")
    if request.fault is Fault.LOSS:
        bus.loss = request.amount
        return ControlReply(done=True, message=f"of the replies {request.amount:.0%} have a wrong CRC")
    if request.fault is Fault.LATE:
        bus.late = request.amount
        return ControlReply(done=True, message=f"replies come {request.amount * 1e3:g} ms late")
    if request.fault is Fault.CLEAR and request.servo is None:
        bus.loss = bus.late = 0.0
    if request.fault is Fault.CRC:
        bus.corrupt = CORRUPT_REPLIES
        return ControlReply(done=True, message=f"the next {CORRUPT_REPLIES} replies have a wrong CRC")
    if not kind.servo and request.servo is None:
        return others.cause(request)
    if request.seconds is not None:
        return ControlReply(done=False, message=f"on wires {request.fault.value} lasts until it is cleared")
    servo = next((one for one in bus.servos if one.id == request.servo), None)
    if servo is None:
        known = ", ".join(str(one.id) for one in bus.servos)
        return ControlReply(done=False, message=f"there is no servo {request.servo}; the servos are {known}")
    if request.fault in (Fault.CUT, Fault.CLEAR):  # the tendon's, which the plant counts from 1
        reply = others.cause(request.model_copy(update={"servo": bus.servos.index(servo) + 1}))
        if request.fault is Fault.CUT:
            return reply
    bus.apply(lambda: _change(servo, request))
    return ControlReply(done=True, message=f"servo {request.servo}: {request.fault.value}")


def _change(servo: EmulatedServo, request: FaultRequest) -> None:
    match request.fault:
        case Fault.BROWNOUT:
            servo.voltage = LOW_VOLTS
        case Fault.TURNED:
            servo.count_turns(round(request.amount))
        case Fault.SILENT:
            servo.silent = True
        case Fault.STUCK:
            servo.stuck = True
        case Fault.HOT:
            servo.temperature = HOT
        case Fault.OVERLOAD:
            servo.fail(OVERLOAD_BIT)
        case Fault.REBOOT:
            servo.power_up()
        case Fault.CLEAR:
            servo.silent = servo.stuck = False
            servo.temperature, servo.voltage = 30.0, 12.0
            servo.power_up()
