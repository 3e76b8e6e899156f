"""Selection on linear problems, whose fits have closed forms: what is taken, what is not, and what has no solution."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.fitting.candidate import Candidate
from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.fitting.selection import UNSOLVED, select
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.simulation.motion import SimulationError

Array = NDArray[np.float64]
NOISE, ROWS = 1e-4, 100
RANDOM = np.random.default_rng(2)
COLUMNS = {name: 1e-3 * RANDOM.standard_normal(3 * ROWS) for name in ("a", "b", "broken")}
COLUMNS["c"] = COLUMNS["a"] + 2e-4 * RANDOM.standard_normal(3 * ROWS)
TRUTH = NOISE * RANDOM.standard_normal(3 * ROWS) + 2.0 * COLUMNS["a"] + 0.5 * COLUMNS["b"]
NAMES = ("broken", "c", "a", "b")


@dataclass
class Line:
    """Residuals that are linear in the parameters; one of them has no solution."""

    parameters: Sequence[Parameter]
    start: Mapping[str, float]
    prior_count: int = field(default=0)

    def values(self, at: Array) -> dict[str, float]:
        moved = zip(self.parameters, at, strict=True)
        return {**self.start, **{one.name: self.start[one.name] + float(x) for one, x in moved}}

    def residuals(self, at: Array) -> Array:
        if any(one.name == "broken" for one in self.parameters):
            raise SimulationError("no solution")
        return np.asarray(sum(value * COLUMNS[name] for name, value in self.values(at).items()) - TRUTH)

    def jacobian(self, at: Array) -> Array:
        if any(one.name == "broken" for one in self.parameters):
            raise SimulationError("no solution")
        return np.array([COLUMNS[one.name] for one in self.parameters]).reshape(-1, 3 * ROWS).T

    def data(self, row: Array) -> Array:
        return row

    def shaped(self, row: Array) -> list[list[Array]]:
        return [[row.reshape(ROWS, 3)]]


def test_the_columns_that_made_the_data_are_taken_and_the_others_say_why_not() -> None:
    candidates = [Candidate(one, (Parameter(one, "-", "", "", "", 1.0, -9.0, 9.0),)) for one in NAMES]
    found = select(
        candidates, dict.fromkeys(NAMES, 0.0), lambda some, start: cast(FitProblem, Line(some, start)), NOISE
    )
    taken = {one.name for one in found.trials if one.taken}
    why = {one.name: one.why for one in found.trials if not one.taken}
    assert taken == {"a", "b"}
    assert why["broken"] == UNSOLVED
    assert why["c"].startswith("not")
    columns = np.stack([COLUMNS["a"], COLUMNS["b"]], axis=1)
    exact = np.linalg.lstsq(columns, TRUTH, rcond=None)[0]
    assert np.allclose([found.values[name] for name in ("a", "b")], exact, rtol=1e-3)
