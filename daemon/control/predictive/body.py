"""Constraints of [safety] as rows of the quadratic program: obstacles, the tip's region, the largest strain.

A distance h (less its margins) is limited at the end of each step, at t_k, and along the motion h_j that follows if the
tensions of knot j, at t_j, are held from now on, which is what the safety filter asks of a command:

    h(t_k) >= e^(-t_k / approach_time) H,    min h_j >= e^(-t_j / approach_time) H

with H the least distance now and along the motion under the tensions applied now. Other tensions than the plan's change
a motion by the plan's derivatives. Surfaces are soft, with a price far above the cost; the strain is hard. Errors of
stiffness count as in the filter; `delay_error` is left to it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import lag_factor_of
from tendond.daemon.control.predictive.horizon import Horizon
from tendond.daemon.control.predictive.program import Rows
from tendond.daemon.control.predictive.rollout import Rollout
from tendond.daemon.control.safety.configured import watched_by
from tendond.daemon.control.safety.geometry import Surfaces
from tendond.model.rods.general import GeneralRod
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.safety.section import SafetySection

Array = NDArray[np.float64]

SPARE = 0.001
"""Distance that a plan keeps beyond what the filter asks for [m], and part of the largest strain: both are linearised,
and the filter looks further ahead. Chosen."""

SIDES = 8
"""Sides of the polygon within which a strain is kept."""


@dataclass(frozen=True)
class BodyLimits:
    """What the body keeps to along a plan.

    Attributes:
        section: [safety]. surfaces: obstacles and the tip's region.
        parts: places of the body, the tip last, parts of its length [-], shape (p,).
        bend_rows: strains of the outermost fibre by the modes, shape (b, 2, n); strain_max: of them [-].
        lag_factor: fraction of a step remaining after a cycle of the actuators' lag [-].
    """

    section: SafetySection
    surfaces: Surfaces
    parts: Array
    bend_rows: Array
    strain_max: float | None
    lag_factor: float = 0.0

    @staticmethod
    def of(config: RigConfig, rod: GeneralRod) -> "BodyLimits | None":
        """Return what [safety] asks for; none where it asks for nothing."""
        found = watched_by(config, rod)
        if found is None:
            return None
        return BodyLimits(
            found.section,
            found.surfaces,
            found.body.parts,
            found.body.bend_rows,
            found.strain_max,
            lag_factor_of(config.observer.lag, config.loop.period),
        )

    def rows(self, horizon: Horizon, rollout: Rollout, plan: Array, applied: Array, shift: Array) -> list[Rows]:
        """Return the limits of a plan's changes.

        Args:
            plan: tensions at the knots [N], shape (B, m). applied: tensions now [N], shape (m,).
            shift: of the tip, by which the observer corrects the model's [m], shape (3,).
        """
        time = self.section.approach_time
        left = [
            np.exp(-times / time) if time > 0.0 else np.zeros(len(times))
            for times in (horizon.ends, horizon.times + 0.5 * horizon.period)
        ]
        found: list[Rows] = []
        commands = Commands.of(horizon, self.lag_factor, plan, applied)
        if self.surfaces.count:
            along = _Along(rollout.points, rollout.points_by_plan, commands, plan)
            found += self._surfaces(along, rollout.points_now, applied, shift, left)
        if self.strain_max is not None:
            turns = self.bend_rows.reshape(-1, self.bend_rows.shape[-1])
            along = _Along(rollout.strain @ turns.T, turns @ rollout.strain_by_plan, commands, plan)
            found += self._strains(along, self.strain_max, applied, left)
        return found

    def _surfaces(self, along: "_Along", now: Array, applied: Array, shift: Array, left: list[Array]) -> list[Rows]:
        moved = (self.parts**2)[:, None] * shift
        here, of_row = now + moved, self.surfaces.point
        start = self.surfaces.measure(here).values - self._margin
        least = np.minimum(self._clear(along.held(applied[None])[0] + moved, here)[0].min(axis=0), start)
        clear, normals = self._clear(along.values + moved, here)
        planned = self.surfaces.slopes(normals, along.by_plan)
        found = [_above(planned, left[0][:, None] * (least - SPARE) + SPARE - clear)]
        clear, normals = self._clear(along.held(along.commands.tension) + moved, here)  # of each knot, shape (B, N, r)
        worst = clear.argmin(axis=1)
        clear = np.take_along_axis(clear, worst[:, None], axis=1)[:, 0]
        normals = np.take_along_axis(normals, worst[:, None, :, None], axis=1)[:, 0]
        slopes = (normals[..., None, :] @ along.by_all[worst, of_row])[..., 0, :]
        return [*found, _above(along.commands.by_plan(slopes), left[1][:, None] * (least - SPARE) + SPARE - clear)]

    @property
    def _margin(self) -> float:
        return self.section.margin + self.section.position_error

    def _clear(self, points: Array, now: Array) -> tuple[Array, Array]:
        """Return distances less margins, shape (..., r), and the surfaces' normals, of points, shape (..., p, 3)."""
        found = self.surfaces.measure(points)
        way = np.linalg.norm(points - now, axis=-1)[..., self.surfaces.point]
        return found.values - self._margin - self.section.stiffness_error * way, found.normals

    def _strains(self, along: "_Along", strain_max: float, applied: Array, left: list[Array]) -> list[Rows]:
        """Return the sides of the polygons about the strains: along the plan, and of each knot at the horizon's end."""
        limit = np.cos(np.pi / SIDES) * (1.0 - 10.0 * SPARE) * strain_max / (1.0 + self.section.stiffness_error)
        held, rest = along.held(along.commands.tension)[:, -1], along.held(applied[None])[0, -1]
        found = []
        for angle in 2.0 * np.pi * np.arange(SIDES) / SIDES:
            side = np.array([np.cos(angle), np.sin(angle)])
            spare = limit - rest.reshape(-1, 2) @ side
            slopes = -side @ along.by_plan.reshape(len(along.values), -1, 2, along.by_plan.shape[-1])
            lack = left[0][:, None] * spare - limit + along.values.reshape(len(along.values), -1, 2) @ side
            found.append(_above(slopes, lack, soft=False))
            slopes = -side @ along.by_all[-1].reshape(-1, 2, along.by_all.shape[-1])
            lack = left[1][:, None] * spare - limit + held.reshape(len(held), -1, 2) @ side
            found.append(_above(along.commands.by_plan(np.tile(slopes, (len(held), 1, 1))), lack, soft=False))
        return found


@dataclass(frozen=True)
class Commands:
    """What is commanded for the tensions of the knots to be reached with the actuators' lag.

    Attributes:
        tension: [N], shape (B, m). shares: of the plan's tensions in them, shape (B, B).
    """

    tension: Array
    shares: Array

    @staticmethod
    def of(horizon: Horizon, lag_factor: float, plan: Array, applied: Array) -> "Commands":
        """Return the commands of a plan [N], shape (B, m), from the tensions applied now [N], shape (m,)."""
        kept = lag_factor ** (horizon.room / horizon.period)
        ahead = 1.0 / (1.0 - kept)
        shares = np.diag(ahead) - np.diag(kept[1:] * ahead[1:], -1)
        tension = shares @ plan
        tension[0] -= kept[0] * ahead[0] * applied
        return Commands(tension, shares)

    def by_plan(self, slopes: Array) -> Array:
        """Return derivatives by the plan, shape (B, r, B m), of numbers that depend on one command each, (B, r, m)."""
        knots, rows, _ = slopes.shape
        return np.asarray(np.einsum("ji,jrm->jrim", self.shares, slopes).reshape(knots, rows, -1))


class _Along:
    """Numbers along a plan, and along others to first order.

    Attributes:
        values: shape (N, ...). by_plan: shape (N, ..., B m). commands: of the plan.
        by_all: derivatives by tensions held along the whole horizon, shape (N, ..., m).
    """

    def __init__(self, values: Array, by_plan: Array, commands: Commands, plan: Array) -> None:
        self.values, self.by_plan, self.commands = values, by_plan, commands
        self.by_all = by_plan.reshape(*by_plan.shape[:-1], *plan.shape).sum(axis=-2)
        self._without = values - by_plan @ plan.ravel()

    def held(self, tensions: Array) -> Array:
        """Return the numbers if tensions [N], shape (h, m), are held from now on, shape (h, N, ...)."""
        return np.asarray(self._without + np.moveaxis(self.by_all @ tensions.T, -1, 0))


def _above(matrix: Array, lower: Array, *, soft: bool = True) -> Rows:
    """Return rows without an upper limit, of matrix (..., v) and limits (...)."""
    return Rows(matrix.reshape(lower.size, -1), lower.ravel(), np.full(lower.size, np.inf), soft)
