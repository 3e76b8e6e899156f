"""Pictures of a camera, newest first, with the time of each: a thread reads them, since a read may block for ever."""

import os
import stat
import threading
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

RETRY_SECONDS = 1.0
"""Pause before a camera that gave no picture is opened again [s]."""

STAMP_AGE_MAX_NS = 1_000_000_000
"""Largest age of a picture by the driver's own stamp; beyond it that is of another clock [ns]."""

JOIN_SECONDS = 2.0
"""Longest wait for the thread at the end: a read that blocks is left to the end of the process [s]."""


@dataclass(frozen=True)
class Picture:
    """A picture.

    Attributes:
        number: counts pictures from 0, with those that were skipped.
        pixels: grey, shape (height, width).
        stamp_ns: time of its exposure where the driver says it, else of its arrival; monotonic clock [ns].
    """

    number: int
    pixels: NDArray[np.uint8]
    stamp_ns: int


class Video:
    """Pictures of a device, a file at its own rate, a named pipe or a URL.

    Args:
        name: device such as /dev/video0, file, named pipe or URL.
        width, height: size that a device is asked for [px]; 0: its own.
        rate: pictures per second that a device is asked for; 0: its own.

    Attributes:
        counts: pictures that were not used, by reason.
        ended: true when a file has come to its end.
    """

    def __init__(self, name: str, width: int = 0, height: int = 0, rate: float = 0.0) -> None:
        cv2.setNumThreads(1)  # the controller's loop is on the same computer
        os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # quiet, AV_LOG_QUIET: the driver says what matters
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
        self._name, self._width, self._height, self._rate = name, width, height, rate
        self.counts: Counter[str] = Counter()
        self.ended = False
        self._news: list[str] = []
        self._newest: Picture | None = None
        self._count = 0
        self._failing = False
        self._stopped = threading.Event()
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._read, name="pictures", daemon=True)
        self._thread.start()

    def next(self, timeout: float) -> Picture | None:
        """Return the newest picture that was not given out yet; none when none came in time.

        Args:
            timeout: longest wait [s].
        """
        with self._changed:
            self._changed.wait_for(lambda: self._newest is not None, timeout)
            picture, self._newest = self._newest, None
        return picture

    def news(self) -> list[str]:
        """Return the lines for people since the last call."""
        with self._changed:
            lines, self._news = self._news, []
        return lines

    def close(self) -> None:
        """Release the camera."""
        self._stopped.set()
        self._thread.join(JOIN_SECONDS)

    def _read(self) -> None:
        """Read pictures until stopped, or to the end of a file."""
        while not self._stopped.is_set():
            capture = self._open()
            came = self._read_all(capture)
            capture.release()
            if came and self._is_file():
                self.ended = True
                self._say(f"the video {self._name} has ended")
                return
            if not self._stopped.is_set():
                if not self._failing:
                    self._say(f"no picture from {self._name}: is the camera connected, and free? opening it again")
                self._failing = True
                self._stopped.wait(RETRY_SECONDS)

    def _open(self) -> cv2.VideoCapture:
        if not self._is_device():
            return cv2.VideoCapture(self._name, cv2.CAP_FFMPEG)
        capture = cv2.VideoCapture(self._name, cv2.CAP_V4L2)
        for property_, value in (
            (cv2.CAP_PROP_FRAME_WIDTH, self._width),
            (cv2.CAP_PROP_FRAME_HEIGHT, self._height),
            (cv2.CAP_PROP_FPS, self._rate),
        ):
            if value:
                capture.set(property_, value)
        return capture

    def _read_all(self, capture: cv2.VideoCapture) -> bool:
        """Read until there is no picture; return whether there was one."""
        period = 1.0 / max(capture.get(cv2.CAP_PROP_FPS), 1.0) if self._is_file() else 0.0
        due, came = time.monotonic(), False
        while not self._stopped.is_set():
            read, pixels = capture.read()
            if not read:
                break
            came = True
            if period:  # a file would be over at once
                due += period
                self._stopped.wait(max(0.0, due - time.monotonic()))
            grey = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
            self._give(np.asarray(grey, dtype=np.uint8), self._stamp(capture))
        return came

    def _stamp(self, capture: cv2.VideoCapture) -> int:
        """Return the time of the picture just read: V4L2 stamps it with the monotonic clock, others do not."""
        now = time.monotonic_ns()
        stamp = round(1e6 * capture.get(cv2.CAP_PROP_POS_MSEC)) if self._is_device() else 0
        return stamp if 0 <= now - stamp <= STAMP_AGE_MAX_NS else now

    def _give(self, pixels: NDArray[np.uint8], stamp_ns: int) -> None:
        with self._changed:
            if self._newest is not None:
                self.counts["pictures skipped"] += 1
            self._newest = Picture(self._count, pixels, stamp_ns)
            self._count += 1
            if self._failing:
                self._failing = False
                self._news.append(f"pictures from {self._name} again")
            self._changed.notify()

    def _say(self, line: str) -> None:
        with self._changed:
            self._news.append(line)

    def _is_device(self) -> bool:
        return self._name.startswith("/dev/video") or _mode(self._name, stat.S_ISCHR)

    def _is_file(self) -> bool:
        return _mode(self._name, stat.S_ISREG)


def _mode(name: str, test: Callable[[int], bool]) -> bool:
    try:
        return test(Path(name).stat().st_mode)
    except OSError:
        return False
