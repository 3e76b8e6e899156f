"""The search for contacts: a filter that knows of none, and what each possible one would leave in its innovations.

Windows that begin every few cycles watch, at little cost, whether a force anywhere explains the innovations (the
generalised likelihood ratio of Willsky and Jones, see `signatures`). Where one may, all onsets within the last cycles
and all places are weighed (`shocks`). What exceeds the threshold is an event: its force acts on the model from then on,
and it is weighed again as more is measured. An event at the place of a contact changes its force, or ends it.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.contact.signatures import carry, heed, weigh, whiten
from tendond.model.estimation.contact.state import Contact, ContactState, Trace
from tendond.model.estimation.contact.weighing import Fit, Weighed, Weigher
from tendond.model.estimation.kalman.factored import Factors, correct, factors_of, propagate
from tendond.model.estimation.kalman.filter import Filter
from tendond.model.estimation.kalman.memory import Moment, Taken
from tendond.model.estimation.kalman.noise import Noise
from tendond.model.estimation.kalman.sensors import Sensor
from tendond.model.numerics.compile import Bound
from tendond.model.rods.general import GeneralRod, GeneralState

Array = NDArray[np.float64]

WINDOWS, SPACING = 5, 4
"""Windows, and cycles between their beginnings: they look back by 16 to 20 cycles."""

SUSPICION = 0.5
"""Part of the threshold from which on a window's statistic has all onsets weighed: with an onset that is wrong by a
cycle it is a fourth lower."""

PATIENCE = 3
"""Cycles between two weighings of a suspicion."""

REMEMBERED = 24
"""Cycles among which an onset is sought."""

CALM = 0.1
"""Part of the estimator's noise of tensions that the search takes: while an arm rests or moves steadily their errors
hardly change, and what they do otherwise raises the threshold."""

NEAREST = 0.2
"""Part of the robot, from its base on, in which no contact is believed: a wrong tension leaves the same traces."""

THRESHOLD = 30.0
"""Statistic of a contact with a robot whose tensions are constant: chi-square with three degrees of freedom exceeds it
once in 7e5; `tendond study contact` counts the false alarms."""

MOTION = 800.0
"""By how much the threshold rises with the square of the bend by which tensions have changed within the remembered
cycles [1/rad^2]: friction may keep a part of that from the robot. `tendond study contact` counts the false alarms."""

WEIGHINGS = (1, 2, 4, 8, 16, 32)
"""Cycles after an alarm at which the event is weighed again; the last one settles it."""

SAME = 0.25
"""Part by which the statistic of the end of a known contact, or of another force at its place, may be below the best
one's, and explains an event nevertheless."""


class Restart(NamedTuple):
    """Errors and their factors before a tick's measurements, with the contact: from there the estimator goes on."""

    tick: int
    before: Array
    factors: Factors
    forces: Array


class ContactSearch:
    """The search of one estimator. Not for use by two threads at once.

    Args:
        rod: the model. noise: what is uncertain, as it is: not as a loop's stability wants it.
        sensors: of the estimator.
    """

    def __init__(self, rod: GeneralRod, noise: Noise, sensors: Sequence[Sensor]) -> None:
        self._stations, self._filter = rod.stations, Filter(rod, noise, sensors)
        self._errors, self._decay = self._filter.errors, self._filter.decay
        errors, decay = self._errors, self._decay
        self._pose = np.array([noise.position] * 3 + [noise.orientation] * 3) ** 2
        n, p, k = errors.size, len(rod.stations.at), 2 * len(errors.kept)
        self._weigher = Weigher(rod.stations, decay, n, noise.load_jump)
        parameters = rod.parameters
        arms = [float(np.hypot(*place)) for place in parameters.tendon_positions]
        self._bends = np.array(arms) * parameters.length / parameters.bending_stiffness  # by each tension [rad/N]
        self._carry, self._heed, self._weigh = Bound(carry), Bound(heed), Bound(weigh)
        self._whiten, self._propagate, self._correct = Bound(whiten), Bound(propagate), Bound(correct)
        self._calm = np.ones(n - k)
        self._calm[errors.drive] = CALM
        self._room, self._weight = np.zeros((n, 2 * n - k)), np.zeros(2 * n - k)
        self._pushed, self._two = np.zeros((k, 3 * p)), np.zeros((2, n))
        self._three = np.zeros((3, 3))
        self._force, self._statistic = np.zeros((WINDOWS, p, 3)), np.zeros((WINDOWS, p))

    def start(self, state: GeneralState) -> ContactState:
        """Start at a model that rests."""
        factors = self._filter.at_rest(state)
        n, p = self._errors.size, len(self._stations.at)
        zero = np.zeros((p, 3))
        return ContactState(0, np.zeros(n), *factors, *self._fresh(), np.zeros(n), zero, zero)

    def heed(self, state: ContactState, moments: Sequence[Moment], until: int) -> tuple[ContactState, Restart | None]:
        """Heed the cycles up to a tick; return where the estimator starts again, if a contact has changed."""
        restart = None
        while state.tick < until:
            index = state.tick + 1 - moments[0].tick
            state, found = self._heed_one(state, moments[index - 1], moments[index])
            restart = restart if found is None else found
        return state, restart

    def _fresh(self) -> tuple[Array, Array, Array]:
        n, p = self._errors.size, len(self._stations.at)
        return np.zeros((WINDOWS, n, 3 * p)), np.zeros((WINDOWS, p, 3, 3)), np.zeros((WINDOWS, p, 3))

    def _heed_one(self, state: ContactState, before: Moment, now: Moment) -> tuple[ContactState, Restart | None]:
        assert before.top is not None
        assert before.pushes is not None
        top, push, tick = before.top, before.pushes.push, now.tick
        k, n = len(top), self._errors.size
        left = state.mean - before.moved
        known = push @ (state.held - before.pushes.fed).reshape(-1)
        mean = np.concatenate((top @ left + known, self._decay * left[k:]))
        caused = push @ state.event.reshape(-1)
        response = np.concatenate((top @ state.response + caused, self._decay * state.response[k:]))
        columns, spread = np.empty((n, n)), np.empty(n)
        self._weight[:n] = state.spread
        noise = self._filter.step_noise(before.pushes.tension) * self._calm
        self._propagate.call(top, self._decay, noise, state.columns, self._weight, self._room, columns, spread)
        trace = self._trace(before, now, mean, Factors(columns, spread))
        windows, information, score = state.windows.copy(), state.information.copy(), state.score.copy()
        if state.alarm < 0:
            if tick % SPACING == 0:
                window = tick // SPACING % WINDOWS
                windows[window], information[window], score[window] = 0.0, 0.0, 0.0
            self._carry.call(top, self._decay, push, windows, self._pushed)
            room = np.empty((len(trace.innovation), push.shape[1]))
            self._heed.call(trace.white, trace.gain, trace.innovation, windows, room, information, score)
        traces = (*state.traces, trace)
        if state.alarm < 0:
            traces = traces[-REMEMBERED:]
        kept = state.event, state.held, traces, state.alarm, state.contact, state.earlier
        state = ContactState(tick, mean, columns, spread, windows, information, score, response, *kept)
        state, restart = self._judged(state)
        columns, spread, mean = state.columns.copy(), state.spread.copy(), state.mean.copy()
        for one in now.taken:
            self._correct.call(one.rows, one.lack, self._variance(one), columns, spread, self._two, mean)
        response = state.response - trace.gain.T @ (trace.white @ state.response)
        windows, information, score = state.windows, state.information, state.score
        kept = state.event, state.held, state.traces, state.alarm, state.contact, state.earlier
        return ContactState(tick, mean, columns, spread, windows, information, score, response, *kept), restart

    def _trace(self, before: Moment, now: Moment, mean: Array, factors: Factors) -> Trace:
        assert before.top is not None
        assert before.pushes is not None
        n = self._errors.size
        if len(now.taken) == 1:
            rows, lack, variance = now.taken[0].rows, now.taken[0].lack, self._variance(now.taken[0])
        else:
            rows = np.concatenate([np.empty((0, n)), *(one.rows for one in now.taken)])
            lack = np.concatenate([np.empty(0), *(one.lack for one in now.taken)])
            variance = np.concatenate([np.empty(0), *(self._variance(one) for one in now.taken)])
        innovation = lack - rows @ mean
        white, gain = np.empty_like(rows), np.empty_like(rows)
        r = len(rows)
        work = np.empty((2 * r, max(r, n)))
        if not self._whiten.call(rows, variance, innovation, *factors, work, white, gain):
            white, gain, innovation = rows[:0], rows[:0], innovation[:0]
        pushes = before.pushes
        return Trace(before.top, pushes.push, white, gain, innovation, pushes.axial, pushes.tension)

    def _variance(self, taken: Taken) -> Array:
        """Variance of a measurement's noise: of the pose, as the search was told."""
        return self._pose[: len(taken.lack)] if taken.sensor == 0 else taken.variance

    def _threshold(self, state: ContactState) -> float:
        first, last = state.traces[0].tension, state.traces[-1].tension
        return THRESHOLD + MOTION * float(np.abs(last - first) @ self._bends) ** 2

    def _judged(self, state: ContactState) -> tuple[ContactState, Restart | None]:
        """Weigh what is due: a suspicion, or an event that has more data."""
        if state.alarm >= 0:
            if state.tick - state.alarm not in WEIGHINGS:
                return state, None
            return self._event(state, self._weigher.weigh(state.traces, state.tick))
        if state.tick % PATIENCE or len(state.traces) < 2:
            return state, None
        threshold = self._threshold(state)
        prior = self._weigher.prior(state.traces[-1].axial)
        self._weigh.call(state.information, state.score, prior, self._three, self._force, self._statistic)
        if float(np.max(self._statistic)) < SUSPICION * threshold:
            return state, None
        weighed = self._weigher.weigh(state.traces, state.tick)
        best = int(np.argmax(weighed.statistic))
        if weighed.statistic[best] < threshold or self._stations.at[best] < NEAREST * self._stations.at[-1]:
            return state, None
        first = state.tick - len(state.traces) + 1
        begin = max(0, int(weighed.onset[best]) - MARGIN - first)
        return self._event(replace(state, alarm=state.tick, traces=state.traces[begin:]), weighed)

    def _event(self, state: ContactState, weighed: Weighed) -> tuple[ContactState, Restart]:
        """Take the likeliest explanation of the present event: a contact, another force of a known one, or its end."""
        contact, event, fit = self._explained(state, weighed)
        response = fit.errors @ event.sum(axis=0)
        state = replace(state, event=event, response=response, contact=contact)
        restart = self._restart(state, fit)
        if state.tick - state.alarm >= WEIGHINGS[-1]:
            windows, information, score = self._fresh()
            state = replace(
                state, mean=restart.before, columns=restart.factors.columns, spread=restart.factors.spread,
                windows=windows, information=information, score=score, response=np.zeros_like(response),
                event=np.zeros_like(event), held=state.held + event, traces=(), alarm=-1, earlier=contact,
            )  # fmt: skip
        return state, restart

    def _explained(self, state: ContactState, weighed: Weighed) -> tuple[Contact | None, Array, Fit]:
        """Return the contact, the force of the event on the stations [N], shape (p, 3), and its fit."""
        at, known = self._stations.at, state.earlier
        best = int(np.argmax(weighed.statistic))
        top, onset = float(weighed.statistic[best]), float(weighed.onset[best])
        place, first, last = self._weigher.locate(weighed)
        force = np.zeros(3)
        if known is not None:
            begun = float(weighed.onset[int(np.argmin(np.abs(at - known.place)))])
            fit = self._weigher.fit(state.traces, state.tick, begun, known.place)
            if fit.statistic_of(-known.force) >= (1.0 - SAME) * top:
                return None, -state.held, fit
            if fit.statistic >= (1.0 - SAME) * top or (first <= known.last and known.first <= last):
                place, first, last, onset, force = known.place, known.first, known.last, begun, known.force
        fit = self._weigher.fit(state.traces, state.tick, onset, place)
        contact = Contact(
            place=place, first=first, last=last, tip=bool(last >= at[-1]), force=force + fit.force,
            deviation=np.sqrt(np.diag(fit.covariance)), statistic=fit.statistic, onset=onset,
            settled=state.tick - state.alarm >= WEIGHINGS[-1],
        )  # fmt: skip
        return contact, np.outer(self._stations.weights(place), fit.force), fit

    def _restart(self, state: ContactState, fit: Fit) -> Restart:
        covariance = Factors(state.columns, state.spread).covariance + fit.errors @ fit.covariance @ fit.errors.T
        return Restart(state.tick, state.mean + state.response, factors_of(covariance), state.forces)


MARGIN = 4
"""Cycles before the likeliest onset at an alarm that are remembered for those to come."""
