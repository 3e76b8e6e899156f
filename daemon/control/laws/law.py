"""The protocol of control laws, and two implementations of it around a plain function."""

from collections.abc import Callable
from dataclasses import dataclass
from types import NoneType
from typing import Annotated, Any, Generic, Protocol, TypeVar

from pydantic import BaseModel, ConfigDict, Field

from tendond.daemon.control.tasks.decision import Decision, LawTerms, Pair
from tendond.daemon.control.tasks.observation import PlanarObservation, SpatialObservation
from tendond.daemon.control.tasks.task import TaskSpace
from tendond.schemas.config.tunable import tunable

__all__ = [
    "Convergence",
    "Decision",
    "Gain",
    "Law",
    "LawParameters",
    "LawTerms",
    "Pair",
    "PlanarObservation",
    "SpatialObservation",
    "StatefulLaw",
    "StatelessLaw",
]

P = TypeVar("P")
O = TypeVar("O")
S = TypeVar("S")

GAIN_RATE = 0.5
"""Largest relative rate of a gain's change while armed [1/s]: in the 0.08 s in which the paper's laws settle, a
gain differs by 4 %, far within the factors of `stability.margins`: the loop meets each value as if it stood still."""

Gain = Annotated[float, Field(gt=0.0, le=1e5, json_schema_extra=tunable(GAIN_RATE))]
"""Parameter of a law: a rate [1/s], positive; tunable while armed."""


class LawParameters(BaseModel):
    """Base of a law's parameters, if it wants one: frozen, finite, nothing unknown."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Convergence:
    """Decay of the model tip's error under a law, as exp(-rate t).

    Attributes:
        rate: rate of the decay [1/s].
        smoothing: rate at which the decay sets in, of a law that places the tip a cycle ahead [1/s]; none of a law that
            sets the tip's velocity in proportion to its error.
    """

    rate: float
    smoothing: float | None = None


class Law(Protocol):
    """A control law: a pure function of parameters, observation and its own state.

    It reads no clock, does no I/O, and keeps nothing but the state that it returns.
    """

    @property
    def name(self) -> str:
        """Name in `control.law`, and of its table of parameters in `control.laws`."""

    @property
    def parameters(self) -> type[Any]:
        """Type of the parameters: anything that pydantic can validate a table into."""

    @property
    def state(self) -> type[Any]:
        """Type of the law's state: a dataclass or a pydantic model; `NoneType` for a law without one."""

    @property
    def task_space(self) -> TaskSpace:
        """`BENDING_PLANE` or `SPACE`: the tendons it uses, the references it follows, the observation it is given."""

    def start(self, parameters: Any) -> Any:
        """Return the state with which tracking begins."""

    def decide(self, parameters: Any, observation: Any, state: Any) -> Decision:
        """Return the tensions wanted, the terms, and the state after the cycle."""

    def convergence(self, parameters: Any) -> Convergence | None:
        """Return the decay of the error, by the parameters: the observer's gains keep their margin with it.

        With none the gains are those for the built-in laws.
        """


@dataclass(frozen=True)
class StatelessLaw(Generic[P, O]):
    """A law that keeps nothing between cycles, from a function of parameters and observation.

    `rates`, a function of the parameters, is its convergence.
    """

    name: str
    parameters: type[P]
    function: Callable[[P, O], Decision]
    task_space: TaskSpace
    state: type[None] = NoneType
    rates: Callable[[P], Convergence] | None = None

    def start(self, parameters: P) -> None:
        """Return none: there is no state."""

    def decide(self, parameters: P, observation: O, state: None) -> Decision:
        """Call the function."""
        return self.function(parameters, observation)

    def convergence(self, parameters: P) -> Convergence | None:
        """Call `rates`, if there is one."""
        return None if self.rates is None else self.rates(parameters)


@dataclass(frozen=True)
class StatefulLaw(Generic[P, O, S]):
    """A law with a state, from a function of parameters, observation and state; `state()` is the state at the start.

    `rates`, a function of the parameters, is its convergence.
    """

    name: str
    parameters: type[P]
    state: type[S]
    function: Callable[[P, O, S], Decision]
    task_space: TaskSpace
    rates: Callable[[P], Convergence] | None = None

    def start(self, parameters: P) -> S:
        """Return the state with its defaults."""
        return self.state()

    def decide(self, parameters: P, observation: O, state: S) -> Decision:
        """Call the function."""
        return self.function(parameters, observation, state)

    def convergence(self, parameters: P) -> Convergence | None:
        """Call `rates`, if there is one."""
        return None if self.rates is None else self.rates(parameters)
