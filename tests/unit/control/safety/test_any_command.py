"""The filter holds against any command: those of no law, as hard as the limits allow, on robots that swing far."""

import numpy as np
import pytest

from tendond.daemon.control.safety.configured import configured_barrier
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import check_config

CYCLES, HELD, PULL = 200, 25, 1.5
"""Cycles of a run, and for which a pull is wanted; largest pull, in EI / (L r): it bends the arm by so many radians."""


@pytest.mark.parametrize("preset", ["rucker-webster-2011", "nitinol"])
@pytest.mark.parametrize(("seed", "error"), [(0, 0.0), (1, 0.0), (0, 0.03)])
def test_no_commands_bring_the_arm_across_a_wall(preset: str, seed: int, error: float) -> None:
    """`error`: by which the tension that acts on a tendon is estimated to differ from its command, of the largest."""
    rng = np.random.default_rng(seed)
    length = check_config({"rod": {"preset": preset}}, "test").rod.backbone_length
    level, zero = 0.3 * length, np.zeros(3)
    wall = {"name": "wall", "kind": "half_space", "normal": (-1.0, 0.0, 0.0), "point": (level, 0.0, 0.0)}
    config = check_config(
        {"rod": {"preset": preset}, "safety": {"margin": 0.005 * length, "obstacle": [wall]}},
        "test",
    )
    rod = model_rod(config)
    assert isinstance(rod, GeneralRod)
    barrier = configured_barrier(config, rod, 0.0)
    assert barrier is not None
    tendons = len(rod.robot.tendons)
    arm = float(np.hypot(*rod.parameters.tendon_positions[0]))
    largest = PULL * rod.parameters.bending_stiffness / (length * arm)
    step, tensions = 0.25 * largest, np.zeros(tendons)
    more = np.concatenate(([error * largest], np.zeros(tendons - 1)))

    def acting(commanded: np.ndarray) -> np.ndarray:
        return np.asarray(commanded + more)

    state = rod.step(rod.solve_static(tensions), tensions)
    beyond, altered = [], 0
    for cycle in range(CYCLES):
        if cycle % HELD == 0:
            pulled = np.zeros(tendons)
            if cycle < CYCLES - 2 * HELD:
                pulled[0 if cycle % (2 * HELD) else rng.integers(0, tendons)] = largest
        low, high = np.maximum(tensions - step, 0.0), np.minimum(tensions + step, largest)
        wanted = np.clip(pulled, low, high)
        found = barrier.filter(state, tensions, zero, zero, wanted, low, high, acting)
        altered += not np.array_equal(found.command, wanted)
        tensions = found.command
        state = rod.step(state, acting(tensions))
        beyond.append(float(rod.strain_rod.backbone(state.strain)[:, 0].max()) - level)
    assert altered > 10
    assert -0.2 * length < max(beyond) < 0.0, "it goes near the wall, and no further"
    assert not tensions.any(), "what leads away from it gets through"


def test_a_delay_error_keeps_the_arm_away_by_its_speed_and_not_at_rest() -> None:
    length = check_config({"rod": {"preset": "nitinol"}}, "test").rod.backbone_length
    distances = []
    for delay_error in (0.0, 0.02):
        wall = {"kind": "half_space", "normal": (-1.0, 0.0, 0.0), "point": (0.3 * length, 0.0, 0.0)}
        safety = {"delay_error": delay_error, "obstacle": [wall]}
        checked = check_config({"rod": {"preset": "nitinol"}, "safety": safety}, "test")
        rod = model_rod(checked)
        assert isinstance(rod, GeneralRod)
        barrier = configured_barrier(checked, rod, 0.0)
        assert barrier is not None
        tensions = np.zeros(len(rod.robot.tendons))
        rest = rod.solve_static(tensions)
        parameters = rod.parameters
        pull = 0.5 * parameters.bending_stiffness / (length * float(np.hypot(*parameters.tendon_positions[0])))
        wanted = np.concatenate(([pull], tensions[1:]))
        found = barrier.filter(
            rod.step(rest, tensions), tensions, np.zeros(3), np.zeros(3), wanted, tensions, tensions + pull
        )
        distances.append((barrier.at_rest(rest.strain)[1], float(found.command[0])))
    (rested, free), (rested_late, late) = distances
    assert rested == rested_late
    assert late < free
