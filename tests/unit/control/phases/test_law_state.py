"""The state and the task of a law: it gets back what it returned, in the plane that it is made for."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.law_state import LawState
from tendond.daemon.control.laws.law import StatefulLaw
from tendond.daemon.control.tasks.decision import Decision, LawTerms
from tendond.daemon.control.tasks.plane import BENDING_PLANE
from tendond.schemas.messages import Mode
from tests.unit.control.phases.scripted_rod import MakeBench


@dataclass(frozen=True)
class Count:
    """State of a law that counts its cycles."""

    cycles: int = 10


def counting(parameters: float, observation: Any, state: Count) -> Decision:
    return Decision(np.full(4, parameters + state.cycles), LawTerms(), Count(state.cycles + 1))


def test_a_law_gets_back_the_state_that_it_returned_and_starts_with_its_own(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_rate = 1e5\n")
    law: Any = StatefulLaw("counting", float, Count, counting, BENDING_PLANE)
    selection = replace(one.start.selection, law_name="counting", law=law, parameters=0.5)
    first = one.go(one.state(selection=selection))
    assert first.state.law_state == LawState("counting", Count(11))
    assert first.state.tension_command == pytest.approx([10.5] * 4)
    second = one.go(first.state)
    assert second.state.law_state == LawState("counting", Count(12))
    assert second.state.tension_command == pytest.approx([11.5] * 4)
    assert one.go(one.state(Mode.PRETENSION, law_state=LawState("counting", Count(3)))).state.law_state is None
    assert one.go(one.state()).state.law_state is None


def test_without_a_pose_on_direct_feedback_a_laws_state_is_kept(bench: MakeBench) -> None:
    one = bench('[control]\nfeedback = "direct"\n')
    kept = LawState("counting", Count(3))
    assert one.go(one.state(law_state=kept)).state.law_state is kept
