"""Tags in a picture, by OpenCV's detector with the dictionaries of AprilTag.

OpenCV has the tags turned by half a turn against the pictures that AprilTag publishes, and so their corners; here top
left is that of the published picture, which is what people print.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from tendond.schemas.config.apriltag import TagFamily

DICTIONARIES: dict[TagFamily, int] = {
    "16h5": cv2.aruco.DICT_APRILTAG_16h5,
    "25h9": cv2.aruco.DICT_APRILTAG_25h9,
    "36h10": cv2.aruco.DICT_APRILTAG_36h10,
    "36h11": cv2.aruco.DICT_APRILTAG_36h11,
}

TWICE = "twice in the picture"


class TagDetector:
    """Finder of the tags of a family.

    Args:
        family: of the tags.
    """

    def __init__(self, family: TagFamily) -> None:
        dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[family])
        self._detector = cv2.aruco.ArucoDetector(dictionary, cv2.aruco.DetectorParameters())

    def find(self, grey: NDArray[np.uint8]) -> dict[int, list[NDArray[np.float64]]]:
        """Return the corners of every tag by its id, to a pixel or so: clockwise from the top left, shape (4, 2) [px].

        A tag that is in the picture twice has two sets of corners.

        Args:
            grey: picture, shape (height, width).
        """
        corners, ids, _ = self._detector.detectMarkers(grey)
        found: dict[int, list[NDArray[np.float64]]] = {}
        for number, one in zip([] if ids is None else np.asarray(ids).reshape(-1).tolist(), corners, strict=True):
            found.setdefault(int(number), []).append(
                np.roll(np.asarray(one, dtype=np.float64).reshape(4, 2), -2, axis=0)
            )
        return found


def draw(family: TagFamily, number: int, side: int) -> NDArray[np.uint8]:
    """Draw a tag's black square without a margin, shape (side, side).

    Raises:
        ValueError: the family has no such tag.
    """
    dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[family])
    count = len(dictionary.bytesList)
    if number >= count:
        raise ValueError(f"family {family} has tags 0 to {count - 1}, not {number}")
    return np.asarray(cv2.aruco.generateImageMarker(dictionary, number, side), dtype=np.uint8)[::-1, ::-1].copy()
