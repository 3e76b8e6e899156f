"""A cycle whose rod is scripted: it stands still, and its displacements follow from the tension by a number."""

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.daemon.control.cycle import respond
from tendond.daemon.control.record import Response
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed, initial_state
from tendond.model.errors import ConvergenceError
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs

Array = NDArray[np.float64]


@dataclass
class ScriptedRod:
    """Replaces what a cycle asks of the rod.

    Attributes:
        base: displacements without tension [m], shape (n,). per_newton: [m/N].
        failures: of the next calls of `step`, how many find no solution.
        steps: tension and tip force of each call.
        elastic: arguments of `displacements`.
    """

    base: Array = field(default_factory=lambda: np.zeros(4))
    per_newton: float = 0.0
    failures: int = 0
    steps: list[tuple[Array, Array]] = field(default_factory=list)
    elastic: list[bool] = field(default_factory=list)

    def step(self, state: Any, tension: Array, *, tip_force: Array) -> Any:
        self.steps.append((tension, tip_force))
        if self.failures:
            self.failures -= 1
            raise ConvergenceError("a time step did not converge", 0.0, 1.0, 60)
        return copy(state)

    def displacements(self, state: Any, *, elastic: bool) -> Array:
        self.elastic.append(elastic)
        return self.base + self.per_newton * self.steps[-1][0]


@dataclass
class Bench:
    """A controller with a scripted rod."""

    setup: CycleSetup
    start: CycleState
    rod: ScriptedRod
    monkeypatch: pytest.MonkeyPatch

    @property
    def period(self) -> float:
        """Period of the cycle [s]."""
        return self.setup.config.loop.period

    def state(self, mode: Mode = Mode.TRACKING, **changes: Any) -> CycleState:
        """Return a state in `mode` since its first cycle, with a pose where the model's tip is."""
        x, y, z = self.start.tip.position.tolist()
        pose = TipPose(seq=7, stamp_ns=0, position=(x, y, z), orientation=(1.0, 0.0, 0.0, 0.0))
        return changed(self.start, **({"mode": mode, "pose": pose, "pose_age": 0, "reason": "set"} | changes))

    def pose(self, state: CycleState, dx: float = 0.0, dy: float = 0.0, dz: float = 0.0) -> TipPose:
        """Return the next pose, beside the model's tip [m]."""
        assert state.pose is not None
        x, y, z = state.tip.position.tolist()
        return state.pose.model_copy(update={"seq": state.pose.seq + 1, "position": (x + dx, y + dy, z + dz)})

    def go(self, state: CycleState, **inputs: Any) -> Response:
        """Run a cycle."""
        return respond(self.setup, state, CycleInputs(**inputs))


MakeBench = Callable[..., Bench]
_MADE: dict[str, tuple[CycleSetup, CycleState]] = {}


def make_bench(monkeypatch: pytest.MonkeyPatch, text: str = "", *, probe: bool = False) -> Bench:
    """Return a bench for a configuration, without the probe unless it is asked for."""
    if not probe:
        text = f"{text}\n[commissioning]\nprobe = false\n"
    if text not in _MADE:
        setup = CycleSetup.from_config(parse_config(text, "test"))
        _MADE[text] = setup, initial_state(setup)
    setup, start = _MADE[text]
    rod = ScriptedRod()
    monkeypatch.setattr(setup.rod, "step", rod.step)
    monkeypatch.setattr(setup.rod, "displacements", rod.displacements)
    return Bench(setup, start, rod, monkeypatch)
