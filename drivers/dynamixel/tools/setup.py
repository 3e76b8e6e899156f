"""Set up a servo: id, baud rate, required register values; reboot it."""

from contextlib import suppress

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import NoReplyError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.models import mismatch, model_of
from tendond.drivers.dynamixel.servos import REBOOT_PINGS
from tendond.drivers.dynamixel.tools.requirements import enable_replies, requirements
from tendond.schemas.config.servo import ServoSection

TRIES = 5


def set_up(bus: ServoBus, old: int, new: int, section: ServoSection) -> list[str]:
    """Set id, baud rate and required values of a servo, which must stand still and be alone with its old id.

    Rate and id come last. After an interruption it can be repeated.

    Args:
        bus: open, of the configured model.
        old, new: id before and after.
        section: [servo], with model and baud rate.

    Returns:
        What was changed.

    Raises:
        ServoError: it does not reply, is of another kind, or another servo has the new id already.
    """
    model = _ping(bus, old)
    if model is None:
        raise ServoError(
            f"servo {old}: does not reply, or several do: plug in one at a time, and see 'tendond servo scan'"
        )
    if other := mismatch(model, bus.model):
        raise ServoError(f"servo {old}: {other}")
    if new != old and _ping(bus, new) is not None:
        raise ServoError(f"servo {new}: there is one already on this bus")
    enable_replies(bus, (old,))
    if bus.read(old, table.TORQUE_ENABLE):
        raise ServoError(f"servo {old}: its torque is on: stop the driver or tool, then 'tendond servo reboot {old}'")
    changed = []
    for one in requirements(bus.model, section):
        before = bus.read(old, one.register)
        if before != one.wanted:
            bus.write(old, one.register, one.wanted)
            changed.append(f"{one.register.name} {before} -> {one.wanted}")
    if new != old:
        with suppress(NoReplyError):  # its reply may be lost, and it is asked by its new id below
            bus.write(old, table.ID, new)
        if _ping(bus, new) is None:
            raise ServoError(f"servo {new}: does not reply after its id was set: run 'tendond servo scan'")
        changed.append(f"ID {old} -> {new}")
    code = bus.model.baud_codes[section.baudrate]
    before = bus.read(new, table.BAUD_RATE)
    if before != code:
        with suppress(NoReplyError):
            bus.write(new, table.BAUD_RATE, code)
        changed.append(f"{table.BAUD_RATE.name} {before} -> {code}")
        bus.transport.set_baudrate(section.baudrate)
    if _ping(bus, new) is None:
        raise ServoError(f"servo {new}: does not reply any more after it was set up: run 'tendond servo scan'")
    return changed


def reboot(bus: ServoBus, identifier: int) -> str:
    """Reboot a servo; then only its gears hold the tendon.

    Returns:
        The hardware errors that it had, in words; empty if none.

    Raises:
        ServoError: it does not reply, before or afterwards.
    """
    if (model := model_of(_ping(bus, identifier) or 0)) is not None:
        bus.model = model  # whatever is configured: it is only rebooted
    enable_replies(bus, (identifier,))
    errors = table.hardware_errors(bus.read(identifier, table.HARDWARE_ERROR_STATUS))
    bus.reboot(identifier)
    if bus.absent((identifier,), REBOOT_PINGS):
        raise ServoError(f"servo {identifier}: does not reply after its reboot: switch its power off and on")
    if left := table.hardware_errors(bus.read(identifier, table.HARDWARE_ERROR_STATUS)):
        raise ServoError(f"servo {identifier}: {', '.join(left)}, after the reboot as well: fix its cause")
    return ", ".join(errors)


def _ping(bus: ServoBus, identifier: int) -> int | None:
    """Return the model number, from one of a few pings; none without a reply."""
    for _ in range(TRIES):
        if (model := bus.ping(identifier)) is not None:
            return model
    return None
