"""Calibration of the tendons, with an operator: id, sign, spool and zero, each confirmed by eye or by the camera."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from tendond import TendondError
from tendond.drivers.dynamixel.calibration import (
    Calibration,
    CalibrationError,
    TendonCalibration,
    now,
    read_calibration,
    save_calibration,
    set_aside,
)
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.tools.camera import Bend, Camera, shortened
from tendond.drivers.dynamixel.tools.motion import energised
from tendond.drivers.dynamixel.tools.rig import ServoRig, open_bus
from tendond.drivers.dynamixel.tools.tendons import pretension, take_over

TURN_ON_TRIAL = math.radians(30.0)
"""Turn of a servo that shows the operator which tendon moves, and in which direction [rad]."""

KNOWN_TURN = math.radians(90.0)
"""Release whose travel gives the spool's radius [rad]."""

RADIUS_DIFFERENCE = 0.1
"""Difference of the measured from the configured radius, relative, above which the operator has to confirm it."""

CAMERA_TRAVEL = 0.004
"""Displacement before the camera [m]: 11 degrees of bend with tendons 20 mm from the axis."""

CAMERA_DIFFERENCE = (0.6, 1.4)
"""Ratio of the camera's to the servo's travel that is accepted: tendons stretch and take up slack first. A radius wrong
by a factor of two, a swapped id and a wrong sign are all outside."""

Ask = Callable[[str], str]
"""Puts a question to the operator; the reply in small letters."""


class MismatchError(TendondError):
    """Error of an observation that does not fit the configuration."""


def calibrate(rig: ServoRig, ask: Ask, show: Callable[[str], None]) -> None:
    """Find id, sign, spool and zero of each tendon; each is saved at once, so that the calibration can be resumed.

    Args:
        rig: to calibrate.
        ask: the operator.
        show: prints a line of the result.

    Raises:
        TendondError: an error of a servo, something that does not fit, or a file that cannot be written.
    """
    path = rig.calibration_file
    done = _begun(rig)
    if len(done) == len(rig.ids):
        kept = set_aside(path)
        show(f"{path} is complete: starting again, the old one is kept as {kept.name if kept else path.name}")
        done = []
    elif done:
        show(f"resuming with tendon {len(done)}: {len(done)} of {len(rig.ids)} are in {path}")
    with open_bus(rig.section) as bus, Camera(rig.config) as camera:
        for index in range(len(done), len(rig.ids)):
            found = _Tendon(rig, bus, camera, index, ask, show).calibrate()
            done.append(found)
            kept_now = Calibration(rig=rig.config.rig.name, date=now(), tendons=tuple(done))
            save_calibration(path, kept_now)
            show(f"tendon {index}: kept in {path}")
    rig.keep(kept_now, dict.fromkeys(rig.ids, 0.0))


def _begun(rig: ServoRig) -> list[TendonCalibration]:
    """Return the tendons of an earlier, unfinished calibration of this rig; a damaged file is set aside."""
    path = rig.calibration_file
    if not path.exists():
        return []
    try:
        calibration = read_calibration(path)
    except CalibrationError as error:
        kept = set_aside(path)
        rig.say(f"{error}; it is set aside as {kept.name if kept else '-'}, all tendons are calibrated again")
        return []
    servos = tuple(tendon.servo for tendon in calibration.tendons)
    if calibration.rig != rig.config.rig.name or servos != rig.ids[: len(servos)]:
        raise MismatchError(f"{path}: is of rig '{calibration.rig}', servos {list(servos)}: name another file")
    return list(calibration.tendons)


@dataclass
class _Tendon:
    """Tendon being calibrated."""

    rig: ServoRig
    bus: ServoBus
    camera: Camera
    index: int
    ask: Ask
    show: Callable[[str], None]

    def __post_init__(self) -> None:
        self.servo = self.rig.ids[self.index]
        self.section = self.rig.section

    def calibrate(self) -> TendonCalibration:
        """Find id and sign by a small turn, spool by a known one, zero by the load; check all of it with the camera."""
        if take_over(self.bus, self.section, self.servo):
            self.show(f"servo {self.servo}: was left on by an interrupted run, is off now")
        self.ask(
            f"Tendon {self.index} (servo {self.servo}): robot straight, tendon slack but on its spool. Enter to go on:"
        )
        trial = TendonCalibration(
            servo=self.servo,
            zero=self.bus.read(self.servo, table.PRESENT_POSITION),
            sign=1,
            spool_radius=self.section.spool_radius,
            ticks_per_turn=self.section.motor.ticks_per_turn,
        )
        signed = trial.model_copy(update={"sign": self._sign(trial)})
        rest = self.camera.bend()
        if rest is None:
            signed = signed.model_copy(update={"spool_radius": self._radius(signed)})
        if objection := self.section.turn_objection(signed.spool_radius, "its radius"):
            raise MismatchError(f"tendon {self.index}: {objection}")
        taut = pretension(self.bus, self.section, Spool(signed), self.rig.tension_max)
        self.show(f"tendon {self.index}: zero at {taut % signed.ticks_per_turn} ticks, where it begins to pull")
        found = signed.model_copy(update={"zero": taut})
        if rest is not None:
            self._before_camera(found)
        return found.model_copy(update={"zero": taut % found.ticks_per_turn})

    def _sign(self, trial: TendonCalibration) -> int:
        """Turn it there and back, and ask which tendon moved in which direction."""
        while True:
            self._turn(trial, TURN_ON_TRIAL, back=True)
            moved = self.ask("It turned 30 degrees and back. Which tendon moved? Its number, 'none' or 'again':")
            if moved == "again":
                continue
            if moved != str(self.index):
                raise MismatchError(
                    f"servo {self.servo} moved tendon {moved or '?'}, not tendon {self.index}: fix servo.ids or the"
                    " tendons' order, then resume"
                )
            reply = self.ask("Did the first turn let it OUT? yes, no or again:")
            if reply in {"yes", "no"}:
                return 1 if reply == "yes" else -1

    def _radius(self, tendon: TendonCalibration) -> float:
        """Release by a known angle, ask for the travel, and return the spool's radius [m]."""
        believed = self.section.spool_radius
        while True:
            self.ask("Mark the tendon where it enters the robot. Enter lets it out by 90 degrees:")
            turned = self._turn(tendon, KNOWN_TURN, back=False)
            travel = _number(self.ask, self.show, "How far did the mark go, in mm?", 1.0, 300.0) * 1e-3
            self._turn(tendon, -turned, back=False)
            radius = travel / turned
            if abs(radius - believed) <= RADIUS_DIFFERENCE * believed:
                return radius
            reply = self.ask(
                f"That makes a radius of {radius * 1e3:.2f} mm, servo.spool_radius is {believed * 1e3:g} mm. Is the"
                " measured one right? yes, or no to measure again:"
            )
            if reply == "yes":
                return radius

    def _turn(self, tendon: TendonCalibration, angle: float, *, back: bool) -> float:
        """Turn by an angle [rad], releasing if `tendon.sign` is correct, and back; return the measured angle."""
        here = tendon.model_copy(update={"zero": self.bus.read(self.servo, table.PRESENT_POSITION)})
        with energised(self.bus, self.section, Spool(here), self.rig.tension_max) as motion:
            for target in (-angle * tendon.spool_radius, 0.0) if back else (-angle * tendon.spool_radius,):
                motion.move(target, self.section.pretension_load, lambda: False)
                if motion.load >= self.section.pretension_load:
                    raise ServoError(f"servo {self.servo}: load {motion.load:.0%}: is the tendon slack?")
            return -tendon.sign * (motion.rest().position - here.zero) * here.tick

    def _before_camera(self, tendon: TendonCalibration) -> None:
        """Pull a little, and check that the tip bends towards this tendon by as much as its radius predicts.

        Raises:
            MismatchError: it does not.
        """
        positions = self.rig.config.rod.tendon_positions
        spool = Spool(tendon)
        places, bends = [], []
        with energised(self.bus, self.section, spool, self.rig.tension_max) as motion:
            for target in (0.0, CAMERA_TRAVEL):  # just taut, and a little more
                motion.move(target, 2.0, lambda: False)
                motion.rest()
                bends.append(self.camera.bend(motion.look))
                places.append(motion.displacement)
            motion.move(0.0, 2.0, lambda: False)
        before, after = bends
        pulled = places[1] - places[0]
        if before is None or after is None:
            raise MismatchError(f"tendon {self.index}: the camera lost the tip while the servo pulled")
        if objection := camera_objection(self.index, positions, pulled, before, after):
            raise MismatchError(f"tendon {self.index} (servo {self.servo}): {objection}")
        measured = shortened(positions[self.index], before, after)
        self.show(
            f"tendon {self.index}: pulled {pulled * 1e3:.1f} mm, the camera measured {measured * 1e3:.1f} mm: id,"
            f" sign, radius"
            " fit"
        )


def camera_objection(
    index: int, positions: tuple[tuple[float, float], ...], pulled: float, before: Bend, after: Bend
) -> str:
    """Compare the camera with a tendon's id, sign and radius; a message if they do not fit, else empty.

    Args:
        index: index of the tendon that was pulled.
        positions: positions of all tendons in the cross-section [m].
        pulled: displacement by the servo, with the assumed radius and sign [m].
        before: bend of the tip.
        after: bend of the tip.
    """
    measured = [shortened(position, before, after) for position in positions]
    towards = max(range(len(measured)), key=lambda one: measured[one] / math.hypot(*positions[one]))
    share = measured[index] / pulled
    low, high = CAMERA_DIFFERENCE
    if towards != index and measured[towards] > low * pulled:
        return f"the tip bent towards tendon {towards}: is the servo's id, or its sign, correct?"
    if share < -low:
        return "the tip bent away from it: is its sign correct?"
    if not low <= share <= high:
        return (
            f"pulled {pulled * 1e3:.1f} mm, the camera measured {measured[index] * 1e3:.1f} mm: is"
            f" servo.spool_radius correct,"
            " the tendon on its spool?"
        )
    return ""


def _number(ask: Ask, show: Callable[[str], None], question: str, lowest: float, highest: float) -> float:
    while True:
        try:
            value = float(ask(question))
        except ValueError:
            value = math.nan
        if lowest <= value <= highest:
            return value
        show(f"a number from {lowest:g} to {highest:g}, please")
