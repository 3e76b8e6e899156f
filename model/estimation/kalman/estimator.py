"""The estimator: the general rod's state with the errors of its inputs, and how sure all of that is.

The model runs under the tensions that the actuators are estimated to apply. Its errors follow the linear model of each
step (`transition`), driven by what is uncertain: the force on the tip drifts and sometimes jumps, tensions are wrong by
a share that changes with friction, the stiffness is a little wrong. A measurement is compared with what was expected at
its own time: the memory keeps the last cycles, takes it there, and carries the correction on to now. So measurements
may be late, out of order, of several rates and kinds: the estimate is the same, in whatever order they come.

Source: R. E. Kalman, "A new approach to linear filtering and prediction problems", J. Basic Eng. 82, 1960; for the
memory, Y. Bar-Shalom, "Update with out-of-sequence measurements", IEEE Trans. Aerosp. Electron. Syst. 38, 2002.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.estimation.contact.search import ContactSearch, Restart
from tendond.model.estimation.contact.state import ContactState
from tendond.model.estimation.kalman.factored import Factors
from tendond.model.estimation.kalman.filter import WINDOW, Filter
from tendond.model.estimation.kalman.memory import Expected, Moment, Reading
from tendond.model.estimation.kalman.noise import Noise
from tendond.model.estimation.kalman.sensors import Sensor, TipPose
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.kalman.taking import place
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.stations import BodyLoads

Array = NDArray[np.float64]

STIFFNESS_MAX = 0.5
"""Largest error of the stiffness that is believed [-]."""

JUMP = 4.0
"""Mean square of these innovations, in units of their expected spread, that is too large. Of 18 numbers it is more than
that once in 1e8 by chance."""

QUIET = 10
"""Cycles after such a jump until the next may be seen: the filter needs some to follow the first. Chosen."""

QUIET_MAX, CALM = 640, 4
"""What comes again and again is no load, but a robot that is not its model: an unknown mass that swings. With each jump
the time until the next doubles, up to `QUIET_MAX` cycles; after `CALM` times as long without one it is `QUIET` again.
Else a loop may swing by the large gains that each jump brings: `tendond study estimator --loop`."""

SQUARE_MAX = 100.0
"""Largest mean square that counts for the consistency: one bad moment is not a bad second."""

LOST = 25.0
"""Consistency beyond which the estimate is one of another robot: the default of faults.inconsistency."""

CONSISTENCY_TIME = 1.0
"""Time over which the consistency is averaged [s]."""


class Estimator:
    """The filter of one robot. Not for use by two threads at once.

    Args:
        rod: the model.
        noise: what is uncertain. sensors: beside the tip's pose, which is the sensor 0.
        age_max: largest age of a measurement against the model [s]; older ones are taken as being of this age.
        contacts: what is uncertain to the search for contacts with the body; none: none are sought.
    """

    def __init__(
        self,
        rod: GeneralRod,
        noise: Noise,
        sensors: Sequence[Sensor] = (),
        age_max: float = 0.0,
        contacts: Noise | None = None,
    ) -> None:
        self.rod, self.noise = rod, noise
        pose = TipPose(math.hypot(noise.position, noise.unmodelled), noise.orientation)
        self.sensors: tuple[Sensor, ...] = (pose, *sensors)
        self.filter = Filter(rod, noise, self.sensors)
        self.errors = self.filter.errors
        self._search = None if contacts is None else ContactSearch(rod, contacts, self.sensors)
        self._length = math.ceil(age_max / rod.time_step - 1e-9) + WINDOW
        self._blend = min(1.0, rod.time_step / CONSISTENCY_TIME)

    def start(self, state: GeneralState, force: Array | None = None) -> EstimatorState:
        """Start at a model that rests, under `force` [N], shape (3,), if any.

        Raises:
            ConvergenceError: the model has no stable rest there.
        """
        zero = np.zeros(self.errors.size)
        moment = Moment(0, self._expect(state), zero, zero, zero, *self.filter.at_rest(state))
        given = np.zeros(3) if force is None else np.array(force, dtype=np.float64)
        m = len(state.tensions)
        bend = np.zeros(len(self.errors.bends))
        sought = None if self._search is None else self._search.start(state)
        known = (moment,), 0, given, np.zeros(m), bend, 0.0, np.zeros(3), 1.0, np.ones(WINDOW)
        return EstimatorState(*known, quiet=QUIET, contacts=sought)

    def correct(
        self, estimate: EstimatorState, state: GeneralState, readings: Sequence[Reading]
    ) -> tuple[EstimatorState, GeneralState]:
        """Take the readings of a cycle; return the estimate, and the model's state moved to it.

        Readings that lead to no finite estimate are left out.
        """
        if not readings:
            return estimate, state
        try:
            after, moved = self._taken(estimate, state, readings)
        except np.linalg.LinAlgError:
            return estimate, state
        numbers = (moved.strain.strain, moved.strain.rate, after.moments[-1].moved, after.recent)
        return (after, moved) if all(np.isfinite(one).all() for one in numbers) else (estimate, state)

    def begun_again(self, estimate: EstimatorState, state: GeneralState) -> tuple[EstimatorState, GeneralState]:
        """Return the estimate of the robot as it is configured, at rest, where it is lost; else the one that is given.

        Corrected on and on, a model that swings otherwise than the robot gains energy without end.
        """
        if estimate.consistency < LOST:
            return estimate, state
        try:
            rest = self.rod.solve_static(state.tensions)
            begun = self.start(rest)
        except ConvergenceError:
            return estimate, state
        tick, contacts = estimate.moments[-1].tick, begun.contacts
        return replace(
            begun,
            moments=(replace(begun.moments[0], tick=tick),),
            front=tick,
            jumped=tick,  # what follows it is no load
            quiet=max(estimate.quiet, QUIET),
            contacts=None if contacts is None else replace(contacts, tick=tick),
        ), rest

    def _taken(
        self, estimate: EstimatorState, state: GeneralState, readings: Sequence[Reading]
    ) -> tuple[EstimatorState, GeneralState]:
        moments, fresh, innovation = place(estimate, readings, self.sensors, self.rod.time_step)
        oldest, recent, jumped, consistency = moments[0].tick, estimate.recent, estimate.jumped, estimate.consistency
        front = max(estimate.front, *fresh)
        first = min(estimate.front, *fresh) - oldest
        heard = max((one.tick for one in moments if any(taken.sensor == 0 for taken in one.taken)), default=-1)
        contacts, restart = self._heeded(estimate, moments, heard)
        moments, squares = self.filter.run(moments, first, front, fresh)
        for tick in sorted(fresh):
            recent = np.append(recent[1:], squares[tick])
            consistency += self._blend * (min(squares[tick], SQUARE_MAX) - consistency)
        quiet = estimate.quiet if front <= max(jumped, 0) + CALM * estimate.quiet else QUIET
        if float(np.mean(recent)) > JUMP and front > max(jumped, 0) + quiet:
            moments, jumped, quiet = self.filter.jumped(moments, front, fresh), front, min(2 * quiet, QUIET_MAX)
        if restart is not None:
            moments, jumped, recent = self._restarted(moments, restart, front), front, np.ones(WINDOW)
        last = moments[-1]
        change, errors = last.after - last.moved, self.errors
        moments[-1] = replace(last, moved=last.after)
        stiffness = min(max(estimate.stiffness_error + float(change[errors.stiffness]), -STIFFNESS_MAX), STIFFNESS_MAX)
        tip_mass = max(estimate.tip_mass + errors.tip_mass_of(change), self.rod.tip_load.least)
        estimate = EstimatorState(
            moments=tuple(moments),
            front=front,
            force=estimate.force + change[errors.force],
            tension_error=estimate.tension_error + change[errors.tension],
            bend_error=estimate.bend_error + change[errors.bend],
            stiffness_error=stiffness,
            innovation=estimate.innovation if innovation is None else innovation,
            consistency=consistency,
            recent=recent,
            jumped=jumped,
            quiet=quiet,
            contacts=contacts,
            tip_mass=tip_mass,
        )
        strain, rate = np.zeros(self.rod.strain_rod.modes), np.zeros(self.rod.strain_rod.modes)
        strain[errors.kept], rate[errors.kept] = change[errors.strain], change[errors.rate]
        return estimate, self.rod.moved(state, strain, rate, 1.0 + stiffness, tip_mass)

    def step(self, estimate: EstimatorState, state: GeneralState, tensions: Array) -> GeneralState:
        """Return the model's state a step later, under tensions [N], shape (m,), with all errors as estimated.

        Raises:
            ConvergenceError: not a finite state.
        """
        pulls = estimate.acting(tensions)
        inner = self.errors.inner_moments(estimate.bend_error)
        moments = self.rod.backbone.turned(state.strain, inner)
        stations = len(self.rod.stations.at)
        forces = np.zeros((stations, 3)) if estimate.contacts is None else estimate.contacts.forces
        return self.rod.step_bent(state, pulls, estimate.force, BodyLoads(moments, forces))

    def advance(self, estimate: EstimatorState, before: GeneralState, after: GeneralState) -> EstimatorState:
        """Go on by a cycle: the model has made a step from one state to the other."""
        newest = estimate.moments[-1]
        known = estimate.moments[estimate.front - estimate.moments[0].tick].factors
        top, noise = self.filter.transition(before, after, known), self.filter.step_noise(after.tensions)
        contacts = estimate.contacts
        pushes = None if contacts is None else self.filter.pushes(contacts.forces, after.tensions)
        newest = replace(newest, top=top, noise=noise, pushes=pushes)
        zero = np.zeros(self.errors.size)
        ahead = Moment(newest.tick + 1, self._expect(after), zero, zero, zero)
        moments, front = (*estimate.moments[:-1], newest, ahead), estimate.front
        if len(moments) > self._length:
            contacts, restart = self._heeded(estimate, moments, moments[1].tick)
            moments = moments if restart is None else tuple(self._restarted(moments, restart, front))
            oldest, second = moments[0], moments[1]
            if front <= oldest.tick:
                second, front = self.filter.carried(oldest, second, self.filter.corrected(oldest)[1]), second.tick
            moments = (second, *moments[2:])
        kept = float(self.filter.decay[3])
        tension, bend = kept * estimate.tension_error, kept * estimate.bend_error
        estimate = replace(estimate, tension_error=tension, bend_error=bend, contacts=contacts)
        return replace(estimate, moments=moments, front=front)

    def tip_covariance(self, estimate: EstimatorState, factors: Factors) -> Array:
        """Return the covariance of the tip's position [m^2], shape (3, 3), by that of the errors now."""
        rows = estimate.moments[-1].expected[0].rows[:3]
        return factors.along(rows) + self.noise.unmodelled**2 * np.eye(3)

    def factors(self, estimate: EstimatorState) -> Factors:
        """Return the covariance of the errors now, with all that was measured."""
        moments = estimate.moments
        index = estimate.front - moments[0].tick
        _, factors = self.filter.corrected(moments[index])
        for moment in moments[index:-1]:
            factors = self.filter.step(moment, factors)
        return factors

    def _heeded(
        self, estimate: EstimatorState, moments: Sequence[Moment], until: int
    ) -> tuple[ContactState | None, Restart | None]:
        """Let the search for contacts heed the cycles up to a tick."""
        if self._search is None or estimate.contacts is None:
            return None, None
        return self._search.heed(estimate.contacts, moments, until)

    def _restarted(self, moments: Sequence[Moment], restart: Restart, front: int) -> list[Moment]:
        """Go on from where a contact has changed: the model is pushed by it from there on."""
        found, first = list(moments), restart.tick - moments[0].tick
        for index in range(first, len(found)):
            pushes = found[index].pushes
            if pushes is not None:
                found[index] = replace(found[index], pushes=replace(pushes, lack=restart.forces - pushes.fed))
        columns, spread = restart.factors
        found[first] = replace(found[first], before=restart.before, columns=columns, spread=spread)
        return self.filter.run(found, first, max(front, restart.tick), ())[0]

    def _expect(self, state: GeneralState) -> tuple[Expected, ...]:
        return tuple(sensor.expect(self.rod, self.errors, state) for sensor in self.sensors)
