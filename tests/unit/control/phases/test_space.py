"""A law's observation in space, number by number: place, prediction and target by the model's linearisation."""

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.control.tasks.decision import Decision, LawTerms
from tendond.daemon.control.tasks.space import SPACE, SpatialTask, tendon_allocation
from tendond.daemon.control.tasks.task import Situation
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.rod import Rod
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.rod.swing import PERIODS_MIN, TIP_LOAD_MAX
from tendond.schemas.record import ReferencePoint

CONFIG = parse_config(
    '[control]\nlaw = "sensitivity"\n[pretension]\ntension_min = 1.5\n[limits]\ntension_max = 40.0\n', "test"
)
SETUP = CycleSetup.from_config(CONFIG)
START = initial_state(SETUP)
PERIOD, ELAPSED, OFFSET = 0.01, 3.0, 0.02
TENSION = np.array([4.0, 3.0, 2.0, 1.0])
POSITION, VELOCITY = np.array([0.1, 0.2, 0.3]), np.array([1.0, 2.0, 3.0])


class ScriptedReference:
    """Its goals name the time that they were asked for."""

    def __init__(self, aim: str) -> None:
        self.aim = aim

    def goal(self, time: float) -> Any:
        return SimpleNamespace(place=np.array([time, 0.0, 1.0]), jacobian=np.full((3, 2), time))


class ScriptedRod:
    """A model whose linearisation is written down; none where it has no solution."""

    def __init__(self, solves: bool = True) -> None:
        self.solves = solves
        self.asked: tuple[Any, ...] = ()

    def predict(self, *arguments: Any) -> Any:
        self.asked = arguments
        if not self.solves:
            raise ConvergenceError("a time step did not converge", 0.0, 1.0, 60)
        return SimpleNamespace(
            position=np.array([0.11, 0.22, 0.33]), position_jacobian=np.full((3, 2), 5.0),
            direction=np.array([0.6, 0.0, 0.8]), direction_jacobian=np.full((3, 2), 7.0),
        )  # fmt: skip


def situation(rod: ScriptedRod, position: Any = POSITION) -> Situation:
    point = ReferencePoint(
        position=(0.4, 0.5, 0.6), velocity=(4.0, 5.0, 6.0), acceleration=(0.0,) * 3, target=(0.0,) * 3
    )
    return Situation(
        rod=cast(Rod, rod), model=START.rod, tip=START.tip, tension=TENSION, acting=TENSION, observer=START.observer,
        position=position,
        velocity=VELOCITY, reference=point, elapsed=ELAPSED, offset=OFFSET, command=TENSION,
        displacement=np.zeros(4),
    )  # fmt: skip


def task(aim: str = "position") -> SpatialTask:
    return SpatialTask(
        cast(Reference, ScriptedReference(aim)), tendon_allocation(CONFIG, SETUP.rod.parameters), PERIOD, 1.5
    )


def test_the_pretension_is_the_minimum_of_every_tendon() -> None:
    assert task().pretension(0.4).tolist() == pytest.approx([0.6] * 4)


def test_a_position_is_predicted_as_far_beside_the_model_as_the_tip_is_now() -> None:
    rod = ScriptedRod()
    beside = np.array([0.001, -0.002, 0.003])
    observation = task().observe(situation(rod, START.tip.position + beside))
    model, tension, shares, force = rod.asked
    assert model is START.rod
    assert tension is TENSION
    assert np.array_equal(shares, tendon_allocation(CONFIG, SETUP.rod.parameters).shares)
    assert np.array_equal(force, START.observer.tip_force)
    assert observation.position == pytest.approx(START.tip.position + beside)
    assert observation.velocity is VELOCITY
    assert (observation.target.tolist(), observation.target_velocity.tolist()) == ([0.4, 0.5, 0.6], [4.0, 5.0, 6.0])
    assert observation.tension is TENSION
    assert observation.period == PERIOD
    assert observation.prediction is not None
    assert observation.prediction.position == pytest.approx(np.array([0.111, 0.218, 0.333]))
    assert observation.prediction.jacobian.tolist() == [[5.0, 5.0]] * 3
    assert np.array_equal(observation.prediction.allocation.tensions(np.zeros(2)), [1.5] * 4)
    assert observation.prediction.target == pytest.approx([ELAPSED + PERIOD, 0.0, 1.0 + OFFSET])
    assert observation.prediction.directions == pytest.approx(np.full((3, 2), ELAPSED + PERIOD))


def test_a_direction_is_the_tips_axis_and_moves_as_the_linearisation_says() -> None:
    observation = task("direction").observe(situation(ScriptedRod()))
    axis = START.tip.rotation[:, 2]
    assert np.array_equal(observation.position, axis)
    assert observation.velocity == pytest.approx((np.array([0.6, 0.0, 0.8]) - axis) / PERIOD)
    assert observation.target == pytest.approx([ELAPSED, 0.0, 1.0])
    assert observation.target_velocity == pytest.approx([1.0, 0.0, 0.0])
    assert observation.prediction is not None
    assert observation.prediction.position.tolist() == [0.6, 0.0, 0.8]
    assert observation.prediction.jacobian.tolist() == [[7.0, 7.0]] * 3


@pytest.mark.parametrize("aim", ["position", "direction"])
def test_without_a_solution_there_is_no_prediction(aim: str) -> None:
    observation = task(aim).observe(situation(ScriptedRod(solves=False)))
    assert observation.prediction is None
    assert observation.position is POSITION
    assert observation.velocity is VELOCITY
    assert observation.tension is TENSION
    assert (observation.target.tolist(), observation.target_velocity.tolist()) == ([0.4, 0.5, 0.6], [4.0, 5.0, 6.0])
    assert observation.period == PERIOD


def test_the_laws_decision_is_taken_as_it_is() -> None:
    seen: list[Any] = []

    def decide(observation: Any) -> Decision:
        seen.append(observation)
        return Decision(2.0 * TENSION, LawTerms())

    ruling = task().rule(decide, situation(ScriptedRod()))
    assert ruling.tension.tolist() == [8.0, 6.0, 4.0, 2.0]
    assert ruling.decision.tension is ruling.tension
    assert seen[0].prediction is not None


def test_a_task_in_space_follows_any_reference_with_all_tendons_between_pretension_and_maximum() -> None:
    made = SPACE.task(CONFIG, SETUP.rod.parameters, SETUP.selection.task.reference)
    assert isinstance(made, SpatialTask)
    assert made.reference is SETUP.selection.task.reference
    assert (made.period, made.tension_min) == (0.01, 1.5)
    for moment in (np.array([10.0, 0.0]), np.array([0.0, -10.0]), np.zeros(2)):
        tensions = made.allocation.tensions(moment)
        assert tensions.min() == pytest.approx(1.5, abs=1e-3)
        assert tensions.max() <= 40.0 + 1e-9
    assert made.allocation.tensions(np.array([10.0, 0.0])).max() == pytest.approx(40.0, abs=1e-3)
    assert SPACE.follows(CONFIG.reference)
    two = parse_config(
        "[rod]\ntendon_positions = [[0.02, 0.0], [-0.02, 0.0]]\n[simulator.rod]\n"
        "tendon_positions = [[0.02, 0.0], [-0.02, 0.0]]\n",
        "test",
    )
    with pytest.raises(ParameterError):
        tendon_allocation(two, rod_from_section(two.rod, PERIOD).parameters)


def test_the_heaviest_tip_is_a_part_of_the_rods_stiffness_and_less_where_a_cycle_is_long() -> None:
    """m = c EI/(g L^2), times (t/15 T)^3 where the rod's time t = sqrt(rho A L^4/EI) is below 15 cycles T.

    Or, if that is less, times the square of the paper's EI/(L r) beside the robot's: of a shorter one here.
    """

    def bound(period: float, **rod: float) -> float:
        lines = "".join(f"{name} = {value}\n" for name, value in rod.items())
        text = f"[loop]\nperiod = {period}\n[rod]\ntendon_stiffness = 2e4\n{lines}[reference]\nacross = 0.1\n"
        config = parse_config(text, "test")
        return SPACE.tip_mass_max(config, rod_from_section(config.rod, period).parameters)

    stiffness = 190e9 * math.pi * 1e-3**4 / 4.0
    rho_a = SETUP.rod.parameters.mass_per_length
    for length in (0.4, 0.5):
        whole = TIP_LOAD_MAX * stiffness / (9.80665 * length**2)
        time = math.sqrt(rho_a * length**4 / stiffness)
        assert bound(0.001, length=length) == pytest.approx(whole * (length / 0.5) ** 2, rel=1e-3)
        long = 2.0 * time / PERIODS_MIN
        assert bound(long, length=length) == pytest.approx(whole / 8.0, rel=1e-3)
