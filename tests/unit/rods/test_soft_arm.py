"""A soft arm is not solved by shooting: there, a step that converges may end in another shape."""

import numpy as np
import pytest

from tendond.model.errors import ConvergenceError
from tendond.model.rods.interface import ModelRod
from tendond.model.rods.selection import model_rod, solver_of
from tendond.schemas.config.rig import check_config
from tendond.schemas.config.robot import RodSection


def worst(rod: ModelRod, seed: int) -> float:
    """Largest motion of the tip in 10 ms under random pulls, over the length; 1 where a step fails."""
    draw, largest = np.random.default_rng(seed), 0.0
    state, tension = rod.solve_static(np.zeros(4)), np.zeros(4)
    target = tension
    for k in range(160):
        if k % 20 == 0:
            target = draw.uniform(0.0, 60.0, 4) * (draw.random(4) < 0.5)
        tension = tension + np.clip(target - tension, -7.0, 7.0)
        try:
            after = rod.step(state, tension)
        except ConvergenceError:
            return 1.0
        moved = float(np.linalg.norm(rod.tip(after).position - rod.tip(state).position))
        largest, state = max(largest, moved / rod.parameters.length), after
    return largest


def rod_of(solver: str | None) -> ModelRod:
    control = {} if solver is None else {"solver": solver}
    return model_rod(check_config({"rod": {"length": 1.0}, "control": control}, "soft"))


def test_the_default_rod_of_a_soft_arm_moves_steadily_where_the_shooting_rod_jumps() -> None:
    seeds = range(4)
    assert max(worst(rod_of("shooting"), seed) for seed in seeds) > 0.35
    assert max(worst(rod_of(None), seed) for seed in seeds) < 0.35


@pytest.mark.parametrize(("length", "solver"), [(0.5, "shooting"), (0.8, "shooting"), (0.9, "general")])
def test_the_papers_wire_is_soft_from_0_9_m_on(length: float, solver: str) -> None:
    assert solver_of(RodSection(length=length), None) == solver


def test_without_gravity_none_is_soft() -> None:
    assert solver_of(RodSection(length=1.2, gravity=(0.0, 0.0, 0.0)), None) == "shooting"
