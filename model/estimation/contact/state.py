"""What is known of a contact, and what the search for it remembers between cycles."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Contact:
    """A force that acts on the body, where nobody said that one would.

    Attributes:
        place: arc length from the base [m]. first, last: places between which the data do not exclude it [m].
        tip: whether the tip is among these: a force there would leave the same traces.
        force: world frame [N], shape (3,). deviation: standard deviation of each component [N], shape (3,).
        statistic: twice the log of the likelihood ratio to no contact, of the event that was seen last [-].
        onset: tick at which it began, as the estimator counts them, with its fraction.
        settled: whether it is not weighed again with more data.
    """

    place: float
    first: float
    last: float
    tip: bool
    force: Array
    deviation: Array
    statistic: float
    onset: float
    settled: bool


@dataclass(frozen=True)
class Trace:
    """A cycle, as far as the search needs it.

    Attributes:
        top, push: transition of the errors from the cycle before, and response to forces, (2 k, N) and (2 k, 3 p).
        white, gain, innovation: of its measurements, in numbers of unit variance, see `signatures.whiten`.
        axial: directions of the backbone at the stations, shape (p, 3). tension: of the tendons [N], shape (m,).
    """

    top: Array
    push: Array
    white: Array
    gain: Array
    innovation: Array
    axial: Array
    tension: Array


@dataclass(frozen=True)
class ContactState:
    """State of the search: a filter that knows of no new force, and what such a force would leave in it.

    Attributes:
        tick: of the last cycle that it has heeded.
        mean, columns, spread: expected errors of the model, without the present event, and their covariance.
        windows: errors by a force since a window's start, shape (w, N, 3 p). information, score: of that force, shapes
            (w, p, 3, 3) and (w, p, 3).
        response: errors by the present event, shape (N,). event: force of it on the stations [N], shape (p, 3).
        held: force of earlier events, likewise.
        traces: of the last cycles, the newest last.
        alarm: tick at which the present event was found; -1: there is none.
        contact: as it is known now. earlier: as it was before the present event.
    """

    tick: int
    mean: Array
    columns: Array
    spread: Array
    windows: Array
    information: Array
    score: Array
    response: Array
    event: Array
    held: Array
    traces: tuple[Trace, ...] = field(default=())
    alarm: int = -1
    contact: Contact | None = None
    earlier: Contact | None = None

    @property
    def forces(self) -> Array:
        """Force on the model's stations in its next step [N], shape (p, 3)."""
        return self.event + self.held
