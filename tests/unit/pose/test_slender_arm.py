"""An arm unlike the paper's in kind, as its user describes it: slender, lightly damped, with a tool; no law named."""

from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.gains import mass_remark, unknown_tip_mass
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.estimation.margin import default_tip_mass
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

ROD: dict[str, Any] = {
    "length": 0.25, "radius": 0.6e-3, "youngs_modulus": 60e9, "density": 6450.0, "damping_ratio": 0.02,
    "tendon_positions": [[0.008, 0.0], [0.0, 0.008], [-0.008, 0.0], [0.0, -0.008]], "tip_mass": 0.015,
}  # fmt: skip
"""Nitinol of 1.2 mm with a tool of 15 g: 33 times as much as the wire's own mass in its first mode."""

TOOL = {"mass": 0.015, "offset": [0.0, 0.0, 0.02]}

RATE = 100.0


def rig(plant: dict[str, Any] | None = None, **changes: Any) -> RigConfig:
    """The arm's configuration; `plant`: [simulator] beside its rod."""
    data: dict[str, Any] = {
        "rod": ROD,
        "reference": {"kind": "minimum_jerk", "duration": 1.0, "across": 0.12},
        "limits": {"tension_max": 20.0},
        "commissioning": {"rest": False, "probe": False},
        "simulator": {"period": 1.0 / RATE, **(plant or {})},
    }
    return check_config({**data, **changes}, "slender")


def end_of(config: RigConfig, seconds: float) -> tuple[Mode, float, float]:
    """Mode at the end, distance of the true tip from its target, and its motion in the last second [m]."""
    runs = list(watched_loop(config, round(seconds * RATE), {2: ControlAction.ARM}))
    tips = np.array([one.truth.position for one in runs[-round(RATE) :]])
    record = runs[-1].record
    away = float(np.linalg.norm(tips[-1] - np.array(record.reference.position)))
    return record.mode, away, float(np.max(np.ptp(tips, axis=0)))


def heavy(**changes: Any) -> dict[str, Any]:
    return {name: value for name, value in {**ROD, **changes}.items() if value is not None}


PAIR = [[0.008, 0.0], [-0.008, 0.0]]
BESIDE = [[0.008, 0.0], [0.0, 0.008]]


@pytest.mark.parametrize(
    "rod",
    [
        ROD,
        heavy(tip_mass=0.0),
        heavy(damping_ratio=0.1),
        heavy(gravity=[9.81, 0.0, 0.0]),
        heavy(tip_mass=None, tip=TOOL),
        heavy(tendon_positions=[[0.008, 0.0]]),
        heavy(tendon_positions=PAIR),
        heavy(tendon_positions=BESIDE, tip_mass=0.0),
    ],
    ids=["tool", "bare", "damped", "horizontal", "long tool", "one tendon", "a pair", "two that oppose nothing"],
)
@pytest.mark.parametrize("observer", ["force", "kalman"])
def test_it_rests_at_its_target(rod: dict[str, Any], observer: str) -> None:
    mode, away, ripple = end_of(rig(rod=rod, observer={"kind": observer}), 5.0)
    assert mode is Mode.TRACKING
    assert away < 0.1e-3
    assert ripple < 0.2e-3


@pytest.mark.parametrize("across", [0.12, 0.14])
def test_a_reference_that_begins_with_a_jump_does_not_throw_it_back(across: float) -> None:
    runs = list(watched_loop(rig(reference={"across": across}), 600, {2: ControlAction.ARM}))
    tips = np.array([one.truth.position for one in runs])
    assert runs[-1].record.mode is Mode.TRACKING
    assert abs(tips[-1, 0] - across) < 0.1e-3
    assert tips[:, 0].max() < across + 0.06
    assert tips[:, 0].min() > tips[2, 0] - 1e-3


UNLIKE = {"mocap": {"noise": 1e-4, "latency": 0.02}}, {"delay": 0.02}


@pytest.mark.parametrize(
    ("plant", "bound"),
    [
        ({"rod": {"youngs_modulus": 54e9}}, 1.5e-3),
        ({"rod": {"youngs_modulus": 66e9}}, 1.5e-3),
        ({"rod": {"damping_ratio": 5e-3}}, 0.5e-3),
        ({"weight": {"mass": 0.005}}, 0.5e-3),
        ({"impacts": [{"time": 3.0, "force": [0.0, 0.1, 0.0], "duration": 0.05}]}, 1e-3),
        ({"rod": {"tendon_friction": 0.1}}, 2e-3),
    ],
    ids=["softer", "stiffer", "hardly damped", "5 g more", "a push", "friction"],
)
def test_a_plant_unlike_the_model_comes_to_rest_there_too(plant: dict[str, Any], bound: float) -> None:
    mode, away, ripple = end_of(rig({**plant, **UNLIKE[0]}, observer=UNLIKE[1]), 8.0)
    assert mode is Mode.TRACKING
    assert away < bound
    assert ripple < 2e-3


@pytest.mark.parametrize("rod", [{"youngs_modulus": 54e9}, {"youngs_modulus": 66e9}, {"damping_ratio": 5e-3}])
def test_the_filter_removes_what_is_left(rod: dict[str, Any]) -> None:
    mode, away, ripple = end_of(rig({"rod": rod, **UNLIKE[0]}, observer={"kind": "kalman", **UNLIKE[1]}), 7.0)
    assert mode is Mode.TRACKING
    assert away < 0.2e-3
    assert ripple < 0.5e-3


def test_friction_that_is_configured_leaves_nothing() -> None:
    plant = {"rod": {"tendon_friction": 0.2}, **UNLIKE[0]}
    mode, away, ripple = end_of(rig(plant, observer=UNLIKE[1], rod=heavy(tendon_friction=0.2)), 7.0)
    assert mode is Mode.TRACKING
    assert away < 0.1e-3
    assert ripple < 0.5e-3


def test_a_bare_arm_that_is_softer_does_not_stay_beside_its_target() -> None:
    """Its loop admits no integral gain with the usual unknown mass, 9 times its own: it has one with less."""
    config = rig({"rod": {"youngs_modulus": 54e9}, **UNLIKE[0]}, rod=heavy(tip_mass=0.0), observer=UNLIKE[1])
    assert end_of(config, 20.0)[1] < 3e-3
    rod = model_rod(config).parameters
    assert unknown_tip_mass(config, rod) < default_tip_mass(rod)
    assert "configure a tool or marker body as rod.tip" in mass_remark(config, rod)


def test_the_papers_law_swings_it() -> None:
    mode, away, ripple = end_of(rig(control={"law": "backstepping"}), 4.0)
    assert mode is Mode.FAULT or ripple > 10e-3 or away > 10e-3


def test_what_is_named_stays_and_what_old_logs_have_too() -> None:
    chosen = rig()
    assert (chosen.control.law, chosen.control.solver) == ("sensitivity", "general")
    assert rig(control={"law": "backstepping"}).control.solver is None
    for old in ({"rules": 1}, {"solver": "shooting"}, {"feedback": "direct"}):
        assert rig(control=old, rod=heavy(damping_ratio=0.1)).control.law == "backstepping"
    assert check_config({"rod": {"tip_mass": 0.05}}, "paper").control.law == "backstepping"


@pytest.mark.parametrize("error", [0.005, 0.02])
def test_the_filter_finds_a_mass_on_the_tip_that_it_does_not_know(error: float) -> None:
    more = 0.005
    plant = {"weight": {"mass": more}, **UNLIKE[0]}
    config = rig(plant, observer={"kind": "kalman", "tip_mass_error": error, **UNLIKE[1]})
    runs = list(watched_loop(config, 500, {2: ControlAction.ARM}))
    record, tips = runs[-1].record, np.array([one.truth.position for one in runs[-100:]])
    known = record.observer.filter
    assert record.mode is Mode.TRACKING
    assert known is not None
    assert known.tip_mass == pytest.approx(more, abs=0.1 * abs(more))
    assert known.consistency < 2.0
    assert np.linalg.norm(tips[-1] - np.array(record.reference.position)) < 0.2e-3
    assert np.ptp(tips, axis=0).max() < 0.5e-3


def test_without_the_mass_among_its_parameters_it_is_lost() -> None:
    observer = {"kind": "kalman", **UNLIKE[1]}
    runs = list(
        watched_loop(rig({"weight": {"mass": 0.005}, **UNLIKE[0]}, observer=observer), 300, {2: ControlAction.ARM})
    )
    assert runs[-1].record.mode is Mode.FAULT
