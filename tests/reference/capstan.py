"""Tendons that rub in a planar bending robot, moved slowly: springs and Coulomb contacts, each case tried by hand.

A rod of cells, each bent evenly, without shear, stretch or weight: the moment in a cell is the sum of arm times tension
of the tendons there, EI k = sum r T. A tendon parallel to it is a chain of springs, one a cell, through contacts: one
before each cell, where it sticks, slides towards the servo or slides towards the tip:

    c (T - T_0) = y_before - y_behind + l - l_0,       l = (1 - r k) ds,
    sticks: y = 0, e^(-mu phi) T_before <= T_behind <= e^(mu phi) T_before;   slides: y > 0 and T_behind at the lower
    bound, or y < 0 and T_behind at the upper one.

phi is the path's bend at the contact (Euler 1769, Eytelwein 1808; as a complementarity problem: RA-L 2026,
DOI 10.1109/LRA.2026.3688094). One linear system is solved for each guess of what the contacts do, and the guess is
changed at the contact that is most wrong until none is (principal pivoting).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
STICKS, PULLED, LET_OUT = 0, 1, -1


@dataclass
class SlowRod:
    """A robot and the state of its tendons.

    Attributes:
        length: [m]. stiffness: EI [N m^2]. arms: of the tendons [m]. spring: of a whole tendon [N/m]. friction: mu.
        cells: of the rod. moment: at the tip, of something else [N m].
        tension: in the cells [N], shape (tendons, cells). curvature: [1/m], shape (cells,). lost: to friction [J].
    """

    length: float
    stiffness: float
    arms: Sequence[float]
    spring: float
    friction: float
    cells: int = 48
    moment: float = 0.0
    lost: float = 0.0
    tension: Array = field(default_factory=lambda: np.zeros(0))
    curvature: Array = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        self.tension = np.zeros((len(self.arms), self.cells))
        self.curvature = np.zeros(self.cells)
        self._guess = np.full((len(self.arms), self.cells), STICKS)

    @property
    def places(self) -> Array:
        """Arc lengths of the cells' middles [m]."""
        return (np.arange(self.cells) + 0.5) * self.length / self.cells

    @property
    def bend(self) -> float:
        """Bend of the whole rod [rad]."""
        return float(self.curvature.sum() * self.length / self.cells)

    def displacement(self, tendon: int) -> float:
        """Displacement of a tendon at its servo [m]: shortening of its path, and stretch."""
        return self.arms[tendon] * self.bend + float(self.tension[tendon].mean()) / self.spring

    def pull(self, pulls: Sequence[float], moment: float = 0.0) -> None:
        """Move on to other tensions at the servos [N], and another moment at the tip [N m]."""
        self.moment = moment
        curvature = self.curvature.copy()
        for _ in range(100):
            ratios = self._ratios(curvature)
            tension, slips, found = self._solve(np.asarray(pulls, dtype=np.float64), ratios)
            settled = float(np.max(np.abs(found - curvature))) < 1e-9 * max(1.0, float(np.max(np.abs(found))))
            curvature = found
            if settled:
                break
        else:
            raise AssertionError("the bends do not settle")
        before = np.concatenate((np.asarray(pulls, dtype=np.float64)[:, None], tension[:, :-1]), axis=1)
        self.lost += float(np.sum(slips * (before - tension)))
        self.tension, self.curvature = tension, found

    def _ratios(self, curvature: Array) -> Array:
        step = self.length / self.cells
        bend = np.abs(curvature) * step
        at_contacts = np.concatenate(([0.5 * bend[0]], 0.5 * (bend[1:] + bend[:-1])))
        return np.exp(-self.friction * at_contacts)

    def _solve(self, pulls: Array, ratios: Array) -> tuple[Array, Array, Array]:
        """Tensions, slips and curvature for given ratios of tensions at sliding contacts."""
        tried: set[bytes] = set()
        for _ in range(2000):
            tension, slips, curvature = self._linear(pulls, ratios)
            before = np.concatenate((pulls[:, None], tension[:, :-1]), axis=1)
            slid = self._guess != STICKS
            low, high = ratios * before - tension, tension - before / ratios
            size = max(float(np.max(np.abs(tension))), 1e-12)
            wrong = np.where(slid, -self._guess * slips * self.spring * self.cells / size, np.maximum(low, high) / size)
            if float(wrong.max()) <= 1e-10:
                return tension, slips, curvature
            if self._guess.tobytes() in tried:  # Murty's rule never goes in circles
                at = tuple(np.argwhere(wrong > 1e-10)[-1])
            else:
                at = np.unravel_index(int(np.argmax(wrong)), wrong.shape)
            tried.add(self._guess.tobytes())
            if slid[at]:
                self._guess[at] = STICKS
            else:
                self._guess[at] = PULLED if low[at] > high[at] else LET_OUT
        raise AssertionError("no case of sticking and sliding fits")

    def _linear(self, pulls: Array, ratios: Array) -> tuple[Array, Array, Array]:
        """Tensions, slips and curvature if the contacts do what is guessed."""
        n, m, step = self.cells, len(self.arms), self.length / self.cells
        compliance = 1.0 / (self.spring * n)
        matrix, right = np.zeros((2 * m * n, 2 * m * n)), np.zeros(2 * m * n)
        at = np.arange(2 * m * n).reshape(2, m, n)  # tensions, slips
        row = 0
        for i in range(m):
            for j in range(n):
                matrix[row, at[0, i, j]] += compliance
                matrix[row, at[1, i, j]] -= 1.0
                if j + 1 < n:
                    matrix[row, at[1, i, j + 1]] += 1.0
                for k in range(m):  # l - l_0 = -r (k - k_0) ds
                    matrix[row, at[0, k, j]] += self.arms[i] * self.arms[k] * step / self.stiffness
                right[row] = compliance * self.tension[i, j] + self.arms[i] * step * (
                    self.curvature[j] - self.moment / self.stiffness
                )
                row += 1
                kind = self._guess[i, j]
                if kind == STICKS:
                    matrix[row, at[1, i, j]] = 1.0
                else:
                    factor = ratios[j] if kind == PULLED else 1.0 / ratios[j]
                    matrix[row, at[0, i, j]] = 1.0
                    if j > 0:
                        matrix[row, at[0, i, j - 1]] = -factor
                    else:
                        right[row] = factor * pulls[i]
                row += 1
        found = np.linalg.solve(matrix, right)
        tension = found[at[0]]
        curvature = (np.asarray(self.arms) @ tension + self.moment) / self.stiffness
        return tension, found[at[1]], curvature
