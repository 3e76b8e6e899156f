"""Checks of the servos and their adapter; registers are only read: nothing moves, no torque is switched."""

import os
import stat
from collections.abc import Sequence
from pathlib import Path

from tendond.cli.doctor.check import CheckOutcome, CheckResult, Rig, failed, passed, warned
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.adapter import WANTED_MS, latency_timer
from tendond.drivers.dynamixel.serial.bus import NoReplyError, PortLostError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.models import MODELS, mismatch
from tendond.drivers.dynamixel.tools.requirements import objections
from tendond.drivers.dynamixel.tools.scan import ports
from tendond.schemas.config.servo import ServoSection

WARM_DEGREES = 10.0
"""Margin below servo.temperature_max in which a servo is warm."""


def port(rig: Rig) -> CheckResult | None:
    """Check that the adapter is plugged in, and that this user may use it."""
    section = rig.config.servo
    if section is None:
        return None
    path = Path(section.port)
    if not path.exists():
        others = ports()
        return failed(
            f"{path} does not exist",
            f"fix servo.port: there {'is' if len(others) == 1 else 'are'} {', '.join(others)}"
            if others
            else "plug in the adapter, and see dmesg",
        )
    if not stat.S_ISCHR(path.stat().st_mode):
        return failed(f"{path} is not a serial port", "fix servo.port")
    if not os.access(path, os.R_OK | os.W_OK):
        return failed(
            f"{path} may not be used by this user", "adduser USER dialout, then log in again (or use the service)"
        )
    real = path.resolve()
    return passed(f"{path}" + (f" ({real})" if real != path else ""))


def latency(rig: Rig) -> CheckResult | None:
    """Check the adapter's latency timer, which delays every reply."""
    section = rig.config.servo
    if section is None or not Path(section.port).exists():
        return None
    found = latency_timer(section.port, rig.machine.sys)
    if found is None:
        return passed("this adapter has no latency timer")
    timer, file = found
    if timer <= WANTED_MS:
        return passed(f"{timer} ms")
    remedy = f"install deploy/udev/70-tendond.rules, or: echo {WANTED_MS} > {file}"
    if timer * 1e-3 >= section.reply_timeout:
        return failed(
            f"{timer} ms, and servo.reply_timeout is {section.reply_timeout * 1e3:g} ms: no reply in time", remedy
        )
    return warned(f"{timer} ms: each reply is delayed by it", remedy)


def servos(rig: Rig) -> CheckResult | None:
    """Check the servos' identity and health; not while a driver uses the port."""
    section = rig.config.servo
    if section is None or not rig.query_servos or not Path(section.port).exists():
        return None
    if rig.activity.states:
        return passed("not queried: in use by the driver")
    ids = section.servo_ids(len(rig.config.rod.tendon_positions))
    try:
        with ServoBus(section.port, section.baudrate, section.reply_timeout, MODELS[section.model]) as bus:
            missing = bus.absent(ids)
            if missing:
                return failed(f"no reply from {_named(missing)}", "switch on their power; then: tendond servo scan")
            if mute := _mute(bus, ids):
                return failed(
                    f"{_named(mute)} replies only to pings: its {table.STATUS_RETURN_LEVEL.name} is 0",
                    "switch its power off and on, or tendond servo setup",
                )
            found = [_ask(bus, one, section) for one in ids]
    except PortLostError as error:
        if "another process" in str(error):
            return warned("not queried: another process uses the port", "end it, or run this again without it")
        return failed(str(error), "check the adapter and servo.port")
    except ServoError as error:
        return failed(str(error), "check cables and power; then: tendond servo scan")
    worst = max(found, key=lambda result: list(CheckOutcome).index(result.outcome))
    if worst.outcome is CheckOutcome.PASS:
        return passed("; ".join(result.finding for result in found))
    wrong = [result for result in found if result.outcome is worst.outcome]
    remedies = dict.fromkeys(result.remedy for result in wrong)
    return CheckResult(worst.outcome, "; ".join(result.finding for result in wrong), "; ".join(remedies))


def _ask(bus: ServoBus, one: int, section: ServoSection) -> CheckResult:
    """Query a servo."""
    model = bus.read(one, table.MODEL)
    if other := mismatch(model, bus.model):
        return failed(f"servo {one}: {other}", "set servo.model, or replace the servo")
    voltage = bus.read(one, table.PRESENT_INPUT_VOLTAGE) * table.VOLTAGE_UNIT
    degrees = bus.read(one, table.PRESENT_TEMPERATURE)
    firmware = bus.read(one, table.FIRMWARE)
    finding = f"servo {one}: {bus.model.name}, firmware {firmware}, {voltage:.1f} V, {degrees} degrees"
    errors = table.hardware_errors(bus.read(one, table.HARDWARE_ERROR_STATUS))
    if errors:
        return failed(f"{finding}, {', '.join(errors)}", f"fix the cause, then tendond servo reboot {one}")
    if not section.voltage_min <= voltage <= section.voltage_max:
        return failed(f"{finding}: not {section.voltage_min:g} to {section.voltage_max:g} V", "check its power supply")
    if degrees > section.temperature_max:
        return failed(f"{finding}: hotter than {section.temperature_max:g}", "let it cool down")
    if wrong := objections(bus, one, section):
        return failed(f"{finding}: {', '.join(wrong)}", f"tendond servo setup {one}")
    if bus.read(one, table.TORQUE_ENABLE):
        return warned(f"{finding}, holds its tendon", "tendond servo home")
    if degrees > section.temperature_max - WARM_DEGREES:
        return warned(f"{finding}: warm", "let it cool down")
    return passed(finding)


def _mute(bus: ServoBus, ids: Sequence[int]) -> list[int]:
    """Find the servos that reply to a ping, but not to a read."""
    mute = []
    for one in ids:
        try:
            bus.read(one, table.MODEL)
        except NoReplyError:
            mute.append(one)
    return mute


def _named(ids: list[int]) -> str:
    return f"servo{'s' if len(ids) > 1 else ''} {', '.join(map(str, ids))}"
