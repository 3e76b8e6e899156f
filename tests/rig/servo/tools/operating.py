"""Operator of the servo tools, and the shafts under their hands."""

from collections.abc import Callable
from pathlib import Path

from tendond.cli.servo.rig import RefusedByOperatorError
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.places import write_places
from tendond.drivers.dynamixel.serial import table
from tests.rig.servos import calibration


class Operator:
    """Operator who replies to questions from a script, and remembers them."""

    def __init__(self, *replies: str | Callable[[], str]) -> None:
        self._replies = list(replies)
        self.asked: list[str] = []

    def __call__(self, question: str) -> str:
        self.asked.append(question)
        if not self._replies:
            raise RefusedByOperatorError("gone away")
        reply = self._replies.pop(0)
        return reply if isinstance(reply, str) else reply()


def place(servos: EmulatedBus, *ticks: float) -> None:
    def put() -> None:
        for servo, at in zip(servos.servos, ticks, strict=True):
            servo._shaft.place(at)

    servos.apply(put)


def mark(servos: EmulatedBus, index: int, radius: float) -> Callable[[], str]:
    """Return a ruler's reading [mm]: travel of a mark on a tendon since the last one, on a spool of `radius` [m]."""
    last = [servos.servos[index].position]

    def look() -> str:
        moved = servos.servos[index].position - last[0]
        last[0] += moved
        return f"{abs(moved) * table.TICK * radius * 1e3:.2f}"

    return look


def calibrated(folder: Path, *last: float, zero: int = 2048) -> None:
    """Save a calibration of both tendons, and their last known displacements [m]."""
    made = calibration((1, -1), zero=zero)
    save_calibration(folder / "calibration.json", made)
    if last:
        write_places(folder / "calibration-places.json", made, {index + 1: place for index, place in enumerate(last)})


def displace(servos: EmulatedBus, *displacements: float) -> None:
    """Turn the shafts to these displacements of the tendons [m], by the calibration of `calibrated`."""
    place(servos, *(2048.0 + sign * one / 0.015 / table.TICK for sign, one in zip((1, -1), displacements, strict=True)))


def displaced(servos: EmulatedBus) -> list[float]:
    """Return the displacement of both tendons by their shafts [m]."""
    return [
        sign * (servo.position - 2048) * table.TICK * 0.015 for sign, servo in zip((1, -1), servos.servos, strict=True)
    ]
