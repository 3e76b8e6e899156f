"""Settings of a drive: its mode, its watchdog and stop, its bounds, its PDOs. Every start makes them anew."""

import math

from tendond.drivers.cia402 import objects
from tendond.drivers.cia402.bus import PRE_OPERATIONAL, RPDO, START, TPDO, DriveBus
from tendond.drivers.cia402.states import POWERED, state_of
from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.strength import GEAR_MARGIN
from tendond.schemas.config.drives import DrivesSection
from tendond.schemas.config.servo import ServoSection

PERMILLE = 1000


def set_up(
    bus: DriveBus, drives: DrivesSection, section: ServoSection, tendon: TendonCalibration, load_limit: float
) -> None:
    """Set up a drive that has no torque, and start its PDOs.

    Args:
        bus: open.
        drives: [drives]. section: [servo].
        tendon: calibration of its tendon; the servo is the node id.
        load_limit: largest load, as a fraction of the rated torque [-].

    Raises:
        ServoError: it is no drive, has not the mode, refuses a setting, still has torque, or does not reply.
    """
    node = tendon.servo
    profile = bus.read(node, objects.DEVICE_TYPE) & 0xFFFF
    if profile != objects.PROFILE:
        raise ServoError(f"servo {node}: has device profile {profile}, not {objects.PROFILE}: it is no drive")
    if not bus.read(node, objects.SUPPORTED_MODES) >> (objects.CYCLIC_POSITION - 1) & 1:
        raise ServoError(f"servo {node}: does not have the cyclic synchronous position mode, which is needed")
    if (state := state_of(bus.read(node, objects.STATUSWORD))) in POWERED:
        raise ServoError(
            f"servo {node}: still holds its tendon from an earlier run, in state '{state}': support the robot and"
            " switch the drive's power off and on"
        )
    bus.command(node, PRE_OPERATIONAL)
    for entry, setting in settings(drives, section, tendon, load_limit).items():
        bus.write(node, entry, setting)
    bus.map_objects(node, objects.RPDO_COB_ID, objects.SENT, RPDO + node)
    bus.map_objects(node, objects.TPDO_COB_ID, objects.RECEIVED, TPDO + node)
    bus.command(node, START)


def settings(
    drives: DrivesSection, section: ServoSection, tendon: TendonCalibration, load_limit: float
) -> dict[objects.Entry, int]:
    """Return the values of a drive's objects; for the arguments see `set_up`."""
    heartbeat = round(PERMILLE * drives.heartbeat)
    value, exponent = _period(section.period)
    wanted = {
        objects.CONSUMER_HEARTBEAT: drives.host_node << 16 | heartbeat,
        objects.ERROR_BEHAVIOUR: objects.KEEP_NMT_STATE,
        objects.ABORT_CONNECTION: objects.ABORT_QUICK_STOP,
        objects.QUICK_STOP_OPTION: objects.STOP_AND_HOLD if drives.stop == "hold" else objects.STOP_AND_DISABLE,
        objects.FAULT_REACTION: objects.REACT_AND_DISABLE,
        objects.FOLLOWING_WINDOW: math.ceil(section.following_error / tendon.spool_radius / tendon.tick),
        objects.FOLLOWING_TIME: round(PERMILLE * section.following_time),
        objects.MAX_TORQUE: int(PERMILLE * min(drives.torque_max, load_limit + GEAR_MARGIN)),
        objects.PERIOD_VALUE: value,
        objects.PERIOD_INDEX: exponent,
        objects.MODE: objects.CYCLIC_POSITION,
    }
    if drives.current_max:
        wanted[objects.MAX_CURRENT] = int(PERMILLE * drives.current_max)
    return wanted


def _period(seconds: float) -> tuple[int, int]:
    """Return a period as value and power of ten, of Interpolation time period."""
    tenths = round(seconds * 1e4)
    return (tenths, -4) if tenths <= 255 else (round(seconds * 1e3), -3)
