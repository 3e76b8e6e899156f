"""Last known displacements of the tendons on disk: they identify the whole turns of rebooted servos."""

import os
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Literal

from pydantic import Field, ValidationError

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.schemas.base import SCHEMA_VERSION, Schema
from tendond.schemas.config.servo import ServoSection

STATE_DIRECTORY = "STATE_DIRECTORY"
"""Environment variable that systemd sets for a service with a state directory."""

INSTALLED, STATES = Path("/etc/tendond"), Path("/var/lib/tendond")

STEP = 0.002
"""Displacement of a tendon after which its place is written again [m]."""


class Places(Schema):
    """Displacements of a rig's tendons, by the id of their servo [m].

    Attributes:
        rig: name of the rig.
        calibration: date of the calibration that they refer to.
        displacement: displacement by servo id [m].
    """

    version: Literal[1] = SCHEMA_VERSION
    rig: str
    calibration: str
    displacement: dict[int, float] = Field(default_factory=dict)


def places_file(folder: Path, section: ServoSection) -> Path:
    """Return the file of the places: in the service's state directory, also for the tools; else beside the calibration.

    Args:
        folder: folder of the configuration.
        section: [servo].
    """
    name = f"{Path(section.calibration).stem}-places.json"
    if state := os.environ.get(STATE_DIRECTORY):
        return Path(state.split(":")[0]) / name
    absolute = folder.absolute()
    if absolute.is_relative_to(INSTALLED):
        kept = STATES / absolute.relative_to(INSTALLED)
        with suppress(OSError):  # of another user
            if kept.is_dir():
                return kept / name
    return folder / Path(section.calibration).with_name(name)


def read_places(path: Path, calibration: Calibration) -> dict[int, float]:
    """Read the last known displacement by servo id [m]; empty without a file for this calibration."""
    try:
        places = Places.model_validate_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, ValidationError):
        return {}
    if (places.rig, places.calibration) != (calibration.rig, calibration.date):
        return {}
    return places.displacement


def write_places(path: Path, calibration: Calibration, displacement: Mapping[int, float]) -> None:
    """Replace the file atomically.

    Raises:
        OSError: it cannot be written.
    """
    places = Places(rig=calibration.rig, calibration=calibration.date, displacement=dict(displacement))
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with beside.open("w", encoding="utf-8") as file:
            file.write(places.model_dump_json() + "\n")
            file.flush()
            os.fsync(file.fileno())
        beside.replace(path)
    except OSError:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        raise


class PlaceKeeper:
    """Writer of the newest places in its own thread, so that a slow disk delays nothing.

    Args:
        path: path of the file.
        calibration: the one that the places refer to.
        say: called once where the file cannot be written.
    """

    def __init__(self, path: Path, calibration: Calibration, say: Callable[[str], None]) -> None:
        self._path = path
        self._calibration = calibration
        self._say = say
        self._written: dict[int, float] = {}
        self._newest: dict[int, float] = {}
        self._wake = threading.Event()
        self._ended = False
        self._failed = False
        self._thread = threading.Thread(target=self._run, name="places", daemon=True)
        self._thread.start()

    def __enter__(self) -> "PlaceKeeper":
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._wake.set()
        self._thread.join()

    def keep(self, displacement: Mapping[int, float]) -> None:
        """Accept places, without waiting; they are written where one has changed by `STEP`."""
        known = self._newest
        if known.keys() == displacement.keys() and all(abs(displacement[i] - known[i]) < STEP for i in known):
            return
        self._newest = dict(displacement)
        self._wake.set()

    def _run(self) -> None:
        ended = False
        while not ended:
            self._wake.wait()
            self._wake.clear()
            ended = self._ended  # the last ones are still written
            newest = self._newest
            if newest == self._written:
                continue
            try:
                write_places(self._path, self._calibration, newest)
            except OSError as error:
                if not self._failed:
                    self._say(
                        f"{self._path}: cannot be written: {error.strerror}; the turns of a rebooted servo will be"
                        " unknown"
                    )
                self._failed = True
            self._written = newest
