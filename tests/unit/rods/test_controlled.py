"""The controller on the general rod: the paper's run, an arm of two sections, a wire that hardly damps."""

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

ARM = {
    "rod": {"preset": "rao-2021"},
    "control": {"law": "sensitivity"},
    "reference": {"across": 0.12},
    "limits": {"tension_max": 6.0},
    "pretension": {"tension_min": 0.1},
}
WIRE = {
    "rod": {"preset": "nitinol"},
    "reference": {"across": 0.05},
    "limits": {"tension_max": 8.0},
    "pretension": {"tension": 0.2, "tension_min": 0.1},
}


def end_of(config: RigConfig, cycles: int = 400) -> tuple[Mode, float, float]:
    """Mode at the end, distance of the true tip from its reference then, and its motion in the last second [m]."""
    runs = list(watched_loop(config, cycles, {5: ControlAction.ARM}))
    tips = np.array([watched.truth.position for watched in runs[-100:]])
    missing = float(np.linalg.norm(tips[-1] - np.array(runs[-1].record.reference.position)))
    return runs[-1].record.mode, missing, float(np.ptp(tips, axis=0).max())


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode", "sensitivity"])
@pytest.mark.parametrize("plant", ["shooting", "general"])
def test_the_papers_robot_ends_on_its_reference_with_either_plant(law: str, plant: str) -> None:
    config = check_config({"control": {"law": law, "solver": "general"}, "simulator": {"solver": plant}}, "test")
    mode, missing, ripple = end_of(config)
    assert mode is Mode.TRACKING
    assert missing < 0.3e-3
    assert ripple < 0.3e-3


def test_an_arm_of_two_sections_reaches_its_target_with_the_law_in_space() -> None:
    mode, missing, ripple = end_of(check_config(ARM, "test"), 600)
    assert mode is Mode.TRACKING
    assert missing < 0.5e-3
    assert ripple < 0.5e-3


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
def test_the_last_section_is_bent_by_the_papers_laws_where_it_is_damped(law: str) -> None:
    arm = {**ARM, "rod": {"preset": "rao-2021", "damping_ratio": 0.3}, "control": {"law": law, "agonist": 3}}
    mode, missing, _ = end_of(check_config({**arm, "reference": {"across": 0.1}}, "test"), 600)
    assert mode is Mode.TRACKING
    assert missing < 0.5e-3


def test_a_wire_of_2_percent_of_damping_is_held_by_the_law_in_space() -> None:
    mode, missing, ripple = end_of(check_config({**WIRE, "control": {"law": "sensitivity"}}, "test"), 600)
    assert mode is Mode.TRACKING
    assert missing < 0.3e-3
    assert ripple < 0.3e-3


def test_a_state_comes_back_from_its_text_and_goes_on_alike() -> None:
    setup = CycleSetup.from_config(check_config(ARM, "test"))
    state = initial_state(setup)
    for tick in range(30):
        state, _, _ = step(setup, state, CycleInputs(request=ControlAction.ARM if tick == 3 else None))
    again = decode_state(CycleState, encode_state(state), setup)
    assert encode_state(again) == encode_state(state)
    ours, theirs = (step(setup, one, CycleInputs())[2].model_dump_json() for one in (state, again))
    assert ours == theirs


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
@pytest.mark.parametrize("preset", ["nitinol", "rucker-webster-2011"])
@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_the_papers_laws_hold_wires_of_2_percent_of_damping(law: str, preset: str, rate: float) -> None:
    wire = {
        **WIRE, "rod": {"preset": preset}, "control": {"law": law}, "loop": {"period": 1.0 / rate},
        "simulator": {"period": 1.0 / rate},
    }  # fmt: skip
    mode, missing, ripple = end_of(check_config(wire, "test"), round(6.0 * rate))
    assert mode is Mode.TRACKING
    assert missing < 0.3e-3
    assert ripple < 0.3e-3


@pytest.mark.parametrize("stiffness", [0.85, 1.15])
@pytest.mark.parametrize("delay", [0, 2])
def test_a_wire_that_is_stiffer_or_softer_than_the_model_settles_as_well(stiffness: float, delay: int) -> None:
    unlike = {
        **WIRE,
        "simulator": {"rod": {"youngs_modulus": stiffness * 54e9}, "mocap": {"latency": 0.01 * delay}},
        "observer": {"delay": 0.01 * delay},
    }
    mode, _, ripple = end_of(check_config(unlike, "test"), 600)
    assert mode is Mode.TRACKING
    assert ripple < 0.8e-3  # it still creeps to its target
