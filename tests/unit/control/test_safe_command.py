"""The last check of a command: whatever has gone wrong in a cycle, what it sends is finite."""

import dataclasses
import math

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import BENDING_PLANE, backstepping
from tendond.daemon.control.laws.law import Decision, PlanarObservation, StatelessLaw
from tendond.daemon.control.state import changed
from tendond.model.rod.rod import Rod
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tests.unit.control.cycles import SETUP, START, armed, follow, pose


@pytest.mark.parametrize("active", [True, False])
def test_a_model_whose_displacements_are_no_numbers_is_a_fault_that_lets_everything_out(
    active: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = armed() if active else START
    seq = 0 if state.pose is None else state.pose.seq + 1
    monkeypatch.setattr(Rod, "displacements", lambda *_, **__: np.array([0.01, math.nan, 0.0, 0.0]))
    for k in range(20):
        state, command, _ = step(SETUP, state, CycleInputs(pose=pose(seq + k, state.tip.position.tolist())))
        assert (state.mode, state.reason) == (Mode.FAULT, "the command was not finite")
        assert not any(command.tension)
        assert not any(command.displacement)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_law_that_asks_for_what_is_no_number_never_reaches_the_tendons(
    value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = armed(150)  # at rest on its target

    def broken(parameters: backstepping.Parameters, observation: PlanarObservation) -> Decision:
        right = backstepping.decide(parameters, observation)
        return dataclasses.replace(right, tension=np.full(4, value))

    law = StatelessLaw("broken", backstepping.Parameters, broken, BENDING_PLANE)
    state = changed(state, selection=dataclasses.replace(state.selection, law=law))
    for _ in range(SETUP.thresholds.limit_time + 2):
        state, command, record = step(SETUP, state, CycleInputs(pose=follow(state)))
        assert np.isfinite(command.tension).all()
        assert np.isfinite(command.displacement).all()
        assert max(command.tension) <= SETUP.config.limits.tension_max
    assert record.mode is Mode.FAULT
