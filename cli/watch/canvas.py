"""Plot in braille: two by four dots to a character, with equal scales across and up."""

import math
from collections.abc import Sequence
from itertools import pairwise

from rich.text import Text

Point = tuple[float, float]
"""Point of a plot, across and up [m]."""

_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Bits of Unicode's braille patterns, by row, then column."""


class Canvas:
    """Window on a plane, in characters.

    Args:
        width, height: size in characters.
        window: left, right, bottom, top [m] to show; the scale is equal in both directions.
    """

    def __init__(self, width: int, height: int, window: tuple[float, float, float, float]) -> None:
        left, right, bottom, top = window
        self._width, self._height = width, height
        self.dot_size = max((right - left) / (2 * width), (top - bottom) / (4 * height))
        """Size of a dot [m]."""
        self._left = 0.5 * (left + right) - width * self.dot_size
        self._top = 0.5 * (top + bottom) + 2 * height * self.dot_size
        self._dots = [[0] * width for _ in range(height)]
        self._marks: dict[tuple[int, int], str] = {}
        self._styles: dict[tuple[int, int], str] = {}

    def dot(self, point: Point, style: str) -> None:
        """Draw a dot, if it is in the window."""
        column = math.floor((point[0] - self._left) / self.dot_size)
        row = math.floor((self._top - point[1]) / self.dot_size)
        if 0 <= column < 2 * self._width and 0 <= row < 4 * self._height:
            self._dots[row // 4][column // 2] |= _BITS[row % 4][column % 2]
            self._styles[row // 4, column // 2] = style

    def line(self, points: Sequence[Point], style: str) -> None:
        """Draw straight lines from point to point."""
        for (x0, y0), (x1, y1) in pairwise(points):
            count = max(1, math.ceil(math.hypot(x1 - x0, y1 - y0) / self.dot_size))
            for i in range(count + 1):
                self.dot((x0 + (x1 - x0) * i / count, y0 + (y1 - y0) * i / count), style)

    def mark(self, point: Point, character: str, style: str) -> None:
        """Draw a character over the dots; at the edge if the point is outside."""
        column = math.floor((point[0] - self._left) / (2 * self.dot_size))
        row = math.floor((self._top - point[1]) / (4 * self.dot_size))
        place = min(max(row, 0), self._height - 1), min(max(column, 0), self._width - 1)
        self._marks[place] = character
        self._styles[place] = style

    def lines(self) -> list[Text]:
        """Return the drawing, a text for each row of characters."""
        rows = []
        for row, dots in enumerate(self._dots):
            text = Text()
            for column, bits in enumerate(dots):
                place = row, column
                character = self._marks.get(place, chr(0x2800 + bits) if bits else " ")
                text.append(character, self._styles.get(place, ""))
            rows.append(text)
        return rows
