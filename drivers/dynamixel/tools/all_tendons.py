"""Every tendon of a rig in turn: moved to its zero, or its slack taken up; positions are saved after each."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from tendond.drivers.dynamixel.calibration import Calibration, now, save_calibration, set_aside
from tendond.drivers.dynamixel.serial.bus import ServoBus
from tendond.drivers.dynamixel.tools.rig import ServoRig
from tendond.drivers.dynamixel.tools.tendons import home, pretension
from tendond.drivers.dynamixel.turns import Located


@dataclass(frozen=True)
class Moved:
    """A tendon that was moved: its index, and its displacement before and after [m]."""

    tendon: int
    before: float
    after: float


@dataclass(frozen=True)
class Taut:
    """A tendon whose slack was taken up: its index, servo, displacement [m] and position [ticks] where it pulls."""

    tendon: int
    servo: int
    displacement: float
    position: int


def home_all(
    rig: ServoRig,
    bus: ServoBus,
    calibration: Calibration,
    located: Sequence[Located],
    stopped: Callable[[], bool],
) -> Iterator[Moved]:
    """Move every tendon to its zero, slowly, the most displaced first.

    Raises:
        ServoError: an error of a servo, or it was stopped.
    """
    for index in sorted(range(len(located)), key=lambda one: -located[one].displacement):
        before, after = home(bus, rig.section, located[index], rig.tension_max, stopped)
        rig.keep(calibration, {located[index].spool.calibration.servo: after})
        yield Moved(index, before, after)


def pretension_all(
    rig: ServoRig, bus: ServoBus, calibration: Calibration, stopped: Callable[[], bool]
) -> Iterator[Taut]:
    """Take up the slack of every tendon, slowly, in order.

    Raises:
        ServoError: an error of a servo, or it was stopped.
    """
    places: dict[int, float] = {}
    for index, one in enumerate(rig.locate(bus, calibration, {})):
        spool, servo = one.spool, one.spool.calibration.servo
        position = pretension(bus, rig.section, spool, rig.tension_max, stopped)
        places[servo] = spool.displacement(position)
        rig.keep(calibration, places)
        yield Taut(index, servo, places[servo], position)


def store_zeros(rig: ServoRig, calibration: Calibration, taut: Sequence[Taut]) -> Path | None:
    """Save a calibration whose zeros are where the tendons pull; the file that the old one was moved to.

    Raises:
        CalibrationError: it cannot be written.
    """
    kept = set_aside(rig.calibration_file)
    tendons = tuple(
        tendon.model_copy(update={"zero": one.position % tendon.ticks_per_turn})
        for tendon, one in zip(calibration.tendons, taut, strict=True)
    )
    renewed = Calibration(rig=calibration.rig, date=now(), tendons=tendons)
    save_calibration(rig.calibration_file, renewed)
    rig.keep(renewed, {one.servo: 0.0 for one in taut})
    return kept
