"""Frames of the robot's tags from a camera's pictures."""

import time
from collections import Counter
from pathlib import Path

from tendond.drivers.apriltag.calibration import load_camera
from tendond.drivers.apriltag.detector import TWICE, TagDetector
from tendond.drivers.apriltag.edges import refined
from tendond.drivers.apriltag.pose import TagPose
from tendond.drivers.apriltag.video import Picture, Video
from tendond.drivers.mocap.frames import POLL_SECONDS, STALE_NS, Frame
from tendond.drivers.mocap.geometry import Placement
from tendond.schemas.config.mocap import MocapSection

BLURRED = "without clear edges"
MISFIT = "does not fit the calibration"
WRONG_SIZE = "pictures of another size than the calibration's"


class TagSource:
    """Placements of the tags at tip and base, in the camera's frame: x right, y down, z along its view.

    Args:
        section: [mocap] with system = 'apriltag'.
        folder: of the configuration, to which the calibration's name is relative.

    Raises:
        CameraError: the calibration cannot be used.

    Attributes:
        counts: irregularities, by name.
        packets: all pictures that were looked at.
        errors: reprojection error of each body in the last picture with it [px].
        video: pictures.
    """

    def __init__(self, section: MocapSection, folder: Path = Path()) -> None:
        tags = section.apriltag
        assert tags.tag_size is not None
        self._camera = load_camera(folder / tags.calibration)
        self._detector = TagDetector(tags.family)
        self._error_max = tags.error_max
        self._ids = {section.tip: tags.tip_tag}
        self._poses = {section.tip: TagPose(self._camera, tags.tag_size)}
        if section.base:
            self._ids[section.base] = tags.base_tag
            self._poses[section.base] = TagPose(self._camera, tags.base_size or tags.tag_size)
        width, height = tags.width or self._camera.width, tags.height or self._camera.height
        self.video = Video(tags.video, width, height, tags.rate)
        self.counts: Counter[str] = self.video.counts
        self.packets = 0
        self.errors: dict[str, float] = {}
        self._size_said = False
        self._news: list[str] = []

    def close(self) -> None:
        """Release the camera."""
        self.video.close()

    def news(self) -> list[str]:
        """Return the lines for people since the last call."""
        lines, self._news = self._news, []
        return self.video.news() + lines

    def receive(self) -> Frame | None:
        """Return the next picture's frame; none when none came for a moment, or one that cannot be used."""
        picture = self.video.next(POLL_SECONDS)
        if picture is None:
            return None
        self.packets += 1
        if time.monotonic_ns() - picture.stamp_ns > STALE_NS:
            self.counts["stale"] += 1
            return None
        height, width = picture.pixels.shape
        if (width, height) != (self._camera.width, self._camera.height):
            self.counts[WRONG_SIZE] += 1
            if not self._size_said:
                self._size_said = True
                self._news.append(
                    f"pictures of {width} x {height} px, but the calibration is of {self._camera.width} x"
                    f" {self._camera.height}: calibrate at this size, or set mocap.apriltag.width and height"
                )
            return None
        return self._frame(picture)

    def _frame(self, picture: Picture) -> Frame:
        """Find the tags in a picture."""
        tags = self._detector.find(picture.pixels)
        objects: dict[str, Placement | None] = {}
        faults: dict[str, str] = {}
        self.errors = {}
        for name, number in self._ids.items():
            found = tags.get(number, [])
            objects[name] = None
            if len(found) != 1:
                if found:
                    faults[name] = TWICE
                continue
            corners = refined(picture.pixels, found[0], self._camera)
            solution = None if corners is None else self._poses[name].update(corners, picture.stamp_ns * 1e-9)
            if solution is None:
                faults[name] = BLURRED
                continue
            self.errors[name] = solution.error
            if solution.error > self._error_max:
                faults[name] = MISFIT
                continue
            objects[name] = solution.placement
        return Frame(picture.number, objects, picture.stamp_ns, faults)
