"""The filter's steps over the memory: what is believed of a cycle, corrected, and carried on to the next one."""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.contact.responses import find_responses
from tendond.model.estimation.kalman.errors import ErrorLayout
from tendond.model.estimation.kalman.factored import Factors, correct, factors_of, propagate
from tendond.model.estimation.kalman.memory import Moment, Pushes
from tendond.model.estimation.kalman.noise import Noise
from tendond.model.estimation.kalman.sensors import Sensor
from tendond.model.estimation.kalman.taking import believed
from tendond.model.estimation.kalman.transition import find_transition
from tendond.model.numerics.compile import Bound
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.friction.hold import hold, without_friction
from tendond.model.strain.stepping.scratch import scratch_for
from tendond.model.strain.tendons import empty_paths, find_paths

Array = NDArray[np.float64]

WINDOW = 3
"""Last measurements whose innovations, if too large together, say that a load has come. Chosen."""

MASS_JUMP = 0.25
"""Part of its deviation that the mass on the tip has again where a load is taken to have come: it may have been the
inertia of that mass, found too surely."""


class Filter:
    """The linear filter of one robot's errors. Not for use by two threads at once.

    Args:
        rod: the model. noise: what is uncertain. sensors: all of them, the tip's pose first.

    Attributes:
        errors: where each stands. decay: of force, tensions and moments, stiffness and mass over a step, (N - 2 k,).
    """

    def __init__(self, rod: GeneralRod, noise: Noise, sensors: Sequence[Sensor]) -> None:
        self._rod, self._noise, self._sensors = rod, noise, sensors
        self.errors = ErrorLayout(rod.strain_rod, noise.tip_mass > 0.0)
        strain, n, k = rod.strain_rod, self.errors.size, len(self.errors.kept)
        self._layout = without_friction(strain.layout) if np.any(strain.layout.friction > 0.0) else strain.layout
        self._work, self._paths = scratch_for(self._layout), empty_paths(strain.layout)
        self._tip = strain.node(strain.robot.length)[1]
        self._matrix, self._two = np.zeros((k, k)), np.zeros((2, n))
        self._room, self._weight = np.zeros((n, 2 * n - 2 * k)), np.zeros(2 * n - 2 * k)
        self.decay = np.ones(n - 2 * k)
        self.decay[self.errors.drive] = math.exp(-rod.time_step / noise.tension_time)
        self._arms = np.array([math.hypot(*place) for place in rod.parameters.tendon_positions])
        self._find, self._propagate, self._correct = Bound(find_transition), Bound(propagate), Bound(correct)
        self._respond = Bound(find_responses)
        self._standing = np.eye(n)[: 2 * k], np.ones(n - 2 * k)
        self._weighed = np.empty((2 * k, 3 * len(rod.tip_load.points)))

    def _believed(self, moment: Moment) -> tuple[Moment, float]:
        """Leave out what cannot belong to this robot; return the mean square of the innovations as well."""
        total, count, kept = 0.0, 0, []
        for one in moment.taken:
            taken, square = believed(one, moment.factors, moment.before, self._sensors[one.sensor].group)
            total, count = total + square, count + len(taken.lack)
            kept.append(taken)
        return replace(moment, taken=tuple(kept)), total / max(count, 1)

    def run(
        self, moments: list[Moment], first: int, front: int, fresh: Collection[int]
    ) -> tuple[list[Moment], dict[int, float]]:
        """Take the measurements again from one moment on; return the mean square of the innovations of each tick."""
        moments, squares = list(moments), {}
        for index in range(first, len(moments)):
            moment, factors = moments[index], None
            if moment.tick <= front:
                if moment.taken:
                    judged, squares[moment.tick] = self._believed(moment)
                    moment = judged if moment.tick in fresh else moment
                moment, factors = self.corrected(moment)
            else:
                moment = replace(moment, after=moment.before)
            moments[index] = moment
            if index + 1 < len(moments):
                ahead = factors if moment.tick < front else None
                moments[index + 1] = self.carried(moment, moments[index + 1], ahead)
        return moments, squares

    def jumped(self, moments: list[Moment], front: int, fresh: Collection[int]) -> list[Moment]:
        """Return the moments with a load that came at the likeliest of the last cycles."""
        newest = front - moments[0].tick
        found: list[tuple[float, list[Moment]]] = []
        for first in range(max(0, newest - WINDOW), newest):
            trial = list(moments)
            trial[first] = self._inflated(trial[first])
            trial, squares = self.run(trial, first, front, fresh)
            unlikely = sum(square for tick, square in squares.items() if tick > front - WINDOW)
            found.append((unlikely, trial))
        return min(found, key=lambda one: one[0])[1] if found else moments

    def _inflated(self, moment: Moment) -> Moment:
        """Let a load have come before the measurements of a cycle."""
        top, decay = self._standing
        noise = np.zeros(len(decay))
        noise[:3] = self._noise.load_jump**2
        noise[self.errors.tip_mass.start - 2 * len(self.errors.kept) :] = (MASS_JUMP * self._noise.tip_mass) ** 2
        factors = self._propagated(top, decay, noise, moment.factors)
        return replace(moment, columns=factors.columns, spread=factors.spread, jumped=True)

    def corrected(self, moment: Moment) -> tuple[Moment, Factors]:
        """Take the measurements of a cycle; return the covariance after them as well."""
        factors, deviation = moment.factors, moment.before
        if moment.taken:
            factors, deviation = factors.copy(), deviation.copy()
            for one in moment.taken:
                self._correct.call(one.rows, one.lack, one.variance, *factors, self._two, deviation)
        return replace(moment, after=deviation), factors

    def carried(self, moment: Moment, following: Moment, factors: Factors | None) -> Moment:
        """Carry what is known after a cycle to the next one; `factors`: the covariance after it, if it is to go on."""
        assert moment.top is not None
        left, t = moment.after - moment.moved, len(moment.top)
        before = np.concatenate((moment.top @ left, self.decay * left[t:]))
        if moment.pushes is not None:
            before[:t] += moment.pushes.push @ moment.pushes.lack.reshape(-1)
        if factors is None:
            return replace(following, before=before)
        ahead = self.step(moment, factors)
        return replace(following, before=before, columns=ahead.columns, spread=ahead.spread)

    def step(self, moment: Moment, factors: Factors) -> Factors:
        assert moment.top is not None
        assert moment.noise is not None
        return self._propagated(moment.top, self.decay, moment.noise, factors)

    def _propagated(self, top: Array, decay: Array, noise: Array, factors: Factors) -> Factors:
        n = self.errors.size
        columns, spread = np.empty((n, n)), np.empty(n)
        self._weight[:n] = factors.spread
        self._propagate.call(top, decay, noise, factors.columns, self._weight, self._room, columns, spread)
        return Factors(columns, spread)

    def transition(self, before: GeneralState, after: GeneralState, factors: Factors | None = None) -> Array:
        """Transition of strains and rates over a step, shape (2 k, N); where it has no model, they stay as they are.

        Args:
            before, after: the model. factors: covariance of its errors, about then; none: its motion is taken as known.
        """
        rod, kept = self._rod, self.errors.kept
        loads = hold(
            rod.strain_rod.layout,
            rod.loads(after.tensions, after.tip_force, after.body),
            before.strain.pulls,
            self._work,
        )
        top = np.empty((2 * len(kept), self.errors.size))
        rod.use(before)
        given = self._layout, loads, before.strain.strain, rod.time_step, kept, self.errors.bends, self.errors.arms
        found = self._find.call(*given, self._tip, before.stiffness, self._work, self._matrix, top)
        top[:, self.errors.tip_mass] = 0.0
        if found and self._noise.tip_mass > 0.0:
            top[:, self.errors.tip_mass] = self._by_mass(before, after, top, factors)[:, None]
        return top if found and np.all(np.isfinite(top)) else self._standing[0].copy()

    def _by_mass(self, before: GeneralState, after: GeneralState, top: Array, factors: Factors | None) -> Array:
        """Strains and rates by a mass on the tip, after the step whose transition was found last [1/kg], (2 k,).

        It is a force: its weight, less what its acceleration a takes. A wrong state accelerates the model, but not the
        robot, and a mass that is told from that is told from noise (W. A. Fuller, "Measurement Error Models", 1987).
        So of a with the variance V only a (a'a)^2 / ((a'a)^2 + V^2) counts: hardly any of noise, and nearly all of a
        swing. With a'a / (a'a + V) 5 g too little on a slender arm were found as 2.
        """
        rod, load, shape, h, k = (
            self._rod,
            self._rod.tip_load,
            self._work.after,
            self._rod.time_step,
            len(self.errors.kept),
        )
        acceleration = (after.velocity - before.velocity) / h
        if factors is not None:
            change = top[k:].copy()
            change[:, k : 2 * k] -= np.eye(k)
            rows = shape.jacobian[self._tip][:, self.errors.kept] @ change / h
            square, variance = float(acceleration @ acceleration), float(np.trace(factors.along(rows)))
            acceleration *= square**2 / max(square**2 + variance**2, 1e-300)
        forces = np.outer(load.shares, np.array(rod.robot.gravity) - acceleration)
        self._respond.call(self._matrix, shape.jacobian, load.points, self.errors.kept, h, self._weighed)
        return np.asarray(self._weighed @ forces.reshape(-1))

    def pushes(self, fed: Array, tensions: Array) -> Pushes:
        """Return what forces along the body do in the step whose transition was found last.

        Args:
            fed: forces by which the model was pushed in it [N], shape (p, 3). tensions: [N], shape (m,).
        """
        stations, shape = self._rod.stations, self._work.after
        push = np.empty((2 * len(self.errors.kept), 3 * len(stations.at)))
        given = stations.points, self.errors.kept, self._rod.time_step
        self._respond.call(self._matrix, shape.jacobian, *given, push)
        return Pushes(push, fed, np.zeros_like(fed), shape.rotation[stations.nodes, 2::3], tensions)

    def step_noise(self, tensions: Array) -> Array:
        """Variance that a step adds to force, tensions, moments, stiffness and mass, shape (N - 2 k,)."""
        known, period = self._noise, self._rod.time_step
        noise = np.zeros(len(self.decay))
        noise[:3] = known.load_rate**2 * period
        noise[self.errors.drive] = (1.0 - self.decay[3] ** 2) * self._drive_variance(tensions)
        return noise

    def _drive_variance(self, tensions: Array) -> Array:
        """Variance of the errors of tensions and moments, shape (m + b,)."""
        known = self._noise
        share = np.where(tensions > 0.0, known.tension_share * tensions + known.tension_floor, 0.0) ** 2
        moment = float(np.sum(share * self._arms**2))
        return np.concatenate((share, np.full(len(self.errors.bends), moment)))

    def at_rest(self, state: GeneralState) -> Factors:
        """Covariance at rest: strains as far from the model's as force, tensions and stiffness may be, and a little."""
        errors, known, rod = self.errors, self._noise, self._rod
        k, n = len(errors.kept), errors.size
        causes = np.zeros(n - 2 * k)
        causes[:3], causes[errors.stiffness - 2 * k] = known.load_start**2, known.stiffness**2
        causes[errors.tip_mass.start - 2 * k :] = known.tip_mass**2
        causes[errors.drive] = self._drive_variance(state.tensions)
        rod.use(state)
        loads = rod.loads(state.tensions, state.tip_force, state.body)
        tangent = rod.strain_rod.tangent(state.strain, loads)
        find_paths(rod.strain_rod.layout, state.strain.strain, self._paths)
        by_force, by_tension = rod.strain_rod.tip_jacobian(state.strain).T, self._paths.gradient.T
        elastic = rod.strain_rod.layout.stiffness @ state.strain.strain / state.stiffness
        bent = np.zeros((k, len(errors.bends)))
        bent[errors.bends, np.arange(len(errors.bends))] = errors.arms
        columns = [by_force[errors.kept], by_tension[errors.kept], bent, -elastic[errors.kept]]
        if known.tip_mass > 0.0:
            carried = rod.strain_rod.shape(state.strain).jacobian[rod.tip_load.points][:, :, errors.kept]
            columns.append(np.einsum("p,pck,c->k", rod.tip_load.shares, carried, rod.robot.gravity))
        pushes = np.column_stack(columns)
        by_causes = np.linalg.solve(tangent[np.ix_(errors.kept, errors.kept)], pushes)
        covariance = np.zeros((n, n))
        covariance[2 * k :, 2 * k :] = np.diag(causes)
        covariance[:k, :k] = (by_causes * causes) @ by_causes.T
        order = rod.strain_rod.layout.order[errors.kept]
        covariance[:k, :k] += np.diag((known.shape / (1.0 + order) / rod.robot.length) ** 2)
        covariance[:k, 2 * k :] = by_causes * causes
        covariance[2 * k :, :k] = covariance[:k, 2 * k :].T
        return factors_of(covariance)
