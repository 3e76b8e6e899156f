"""The observer: it finds loads on the tip, and what is known of delay and lag costs nothing."""

from itertools import pairwise

import numpy as np
import pytest

from tendond.drivers.simulator.lockstep import closed_loop
from tendond.model.estimation.compliance import tip_compliance
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

ARM = 5
GRAVITY = 9.81


def run(text: str, cycles: int = 250, arm: int | None = ARM) -> list[CycleRecord]:
    requests = {} if arm is None else {arm: ControlAction.ARM}
    return list(closed_loop(parse_config(text, "test"), cycles, requests))


def tips(records: list[CycleRecord]) -> np.ndarray:
    return np.array([r.measured for r in records if r.mode is Mode.TRACKING], dtype=np.float64)


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
@pytest.mark.parametrize("mass", [0.02, 0.05])
@pytest.mark.parametrize("arm", [ARM, None], ids=["bent", "idle"])
def test_a_weight_hung_on_the_tip_is_found_within_a_tenth_in_three_seconds(
    law: str, mass: float, arm: int | None
) -> None:
    records = run(f'[control]\nlaw = "{law}"\n[simulator.weight]\nmass = {mass}\ntime = 1.5', cycles=600, arm=arm)
    for record in records[450:]:
        assert record.observer.force[0] == pytest.approx(-mass * GRAVITY, rel=0.1)
        assert abs(record.observer.force[2]) < 0.1 * mass * GRAVITY + 0.01
    assert abs(records[149].observer.force[0]) < 1e-6


def test_the_model_then_rests_where_the_loaded_arm_does() -> None:
    records = run("[simulator.weight]\nmass = 0.05", cycles=600)
    assert records[-1].measured is not None
    assert np.linalg.norm(np.subtract(records[-1].model.position, records[-1].measured)) < 2e-4
    assert records[-1].measured[0] == pytest.approx(0.34, abs=1e-3)  # z yields to the load, x does not


@pytest.mark.parametrize("kind", ["force", "offset"])
def test_a_delay_that_is_known_changes_nothing(kind: str) -> None:
    plain = tips(run(f'[observer]\nkind = "{kind}"'))
    late = run(f'[observer]\nkind = "{kind}"\ndelay = 0.04\n[simulator.mocap]\nlatency = 0.04')
    np.testing.assert_allclose(tips(late)[4:], plain[: len(tips(late)) - 4], atol=1e-6)


def test_a_lag_that_is_known_is_led_and_an_unknown_one_is_not() -> None:
    """Time constant of 45 ms: a fifth of a step in the first cycle. The command leads, the arm moves as if without."""
    fast = "[limits]\ntension_rate = 6000.0\n"  # a lead is faster than what it leads
    plain = tips(run(fast))
    known = tips(run(f"{fast}[observer]\nlag = 0.045\n[simulator.servo]\nlag = 0.045"))
    unknown = tips(run(f"{fast}[simulator.servo]\nlag = 0.045"))
    assert np.abs(np.diff(known[:, 0])).sum() == pytest.approx(np.abs(np.diff(plain[:, 0])).sum(), rel=0.01)
    first = [int(np.flatnonzero(run_[:, 0] > 0.9 * 0.34)[0]) for run_ in (plain, known, unknown)]
    assert first[1] <= first[0] + 4 < first[2] + 4
    np.testing.assert_allclose(known[-1], plain[-1], atol=1e-5)


def test_noise_reaches_the_arm_as_less_than_a_third_of_itself() -> None:
    records = run("[simulator.mocap]\nnoise = 3.0e-4\n[simulator]\nseed = 3", cycles=400)
    still = np.array([r.model.position for r in records[200:]])
    assert np.linalg.norm(still[:, [0, 2]].std(axis=0)) < 1e-4


def test_the_offset_observer_adds_what_the_model_misses_and_estimates_no_force() -> None:
    records = run('[observer]\nkind = "offset"\n[simulator.rod]\nyoungs_modulus = 1.8e11')
    last = records[-1].observer
    assert last.force == last.pull == (0.0, 0.0, 0.0)
    missing = np.subtract(records[-1].measured or (), records[-2].model.position)
    np.testing.assert_allclose(last.offset, missing, atol=1e-4)


def test_the_force_is_bounded() -> None:
    records = run("[observer]\nforce_max = 0.1\n[simulator.weight]\nmass = 0.05", cycles=100, arm=None)
    assert np.linalg.norm(records[-1].observer.force) == pytest.approx(0.1)


def test_without_a_pose_the_force_stays_and_nothing_pulls() -> None:
    records = run("[simulator.weight]\nmass = 0.05\n[simulator.mocap]\nperiod = 0.05\n", cycles=100, arm=None)
    assert any(r.inputs.pose is None for r in records)
    for before, after in pairwise(records):
        if after.inputs.pose is None:
            assert after.observer.pull == (0.0, 0.0, 0.0)
            assert after.observer.force == before.observer.force


@pytest.mark.parametrize("tension", [0.0, 5.0, 40.0])
def test_the_compliance_is_near_that_of_the_bent_rod(tension: float) -> None:
    """Unit-load method against differences of statics: some parts in ten, for it knows nothing of the tendon's pull."""
    config = RigConfig()
    rod = rod_from_section(config.rod, config.loop.period)
    pull = [tension, 0.0, 0.0, 0.0]
    state = rod.solve_static(pull)
    columns = []
    for axis in range(3):
        force = np.zeros(3)
        force[axis] = 1e-3
        there, back = (rod.tip(rod.solve_static(pull, tip_force=s * force)).position for s in (1.0, -1.0))
        columns.append((there - back) / 2e-3)
    exact = np.column_stack(columns)
    assert np.linalg.norm(tip_compliance(rod, state) - exact) < 0.35 * np.linalg.norm(exact)


def test_an_arm_that_an_impact_moves_past_its_target_comes_back() -> None:
    """It is held by the target's tension where the law's inverse of b_c has the wrong sign."""
    records = run(
        "[[simulator.impacts]]\ntime = 1.0\nduration = 0.05\nforce = [0.0, 0.0, 10.0]\n"
        "[simulator.rod]\nyoungs_modulus = 1.615e11\nbending_damping = [0.004, 0.004, 0.004]\n",
        cycles=300,
    )
    x = [r.measured[0] for r in records[100:] if r.measured is not None]
    assert min(x) < 0.1
    assert records[-1].mode is Mode.TRACKING
    assert x[-1] == pytest.approx(0.34, abs=2e-3)
