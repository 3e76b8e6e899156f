"""Friction of the simulated tendons: the capstan along a rod that its tendon bends, in closed form, and the laws."""

import math
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tendond.drivers.simulator.rods import GeneralPlantRod, plant_rod, plant_solver
from tendond.model import RodParameters
from tendond.model.errors import ParameterError
from tendond.model.rods.selection import Solver
from tendond.offline.bench.friction import (
    COEFFICIENTS,
    HEADING,
    STEPS,
    FrictionLoop,
    pull_and_release,
    run_rig,
)
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import check_config, parse_config
from tendond.schemas.config.simulator import SimulatorSection

ROD = RodParameters()
ARM = 0.02
STIFFNESS = 2e4
DOCS = Path(__file__).parents[3] / "docs" / "simulator.md"


@cache
def loop(coefficient: float) -> FrictionLoop:
    return pull_and_release(coefficient, STIFFNESS)


def by_hand(pull: float, coefficient: float, sign: float) -> tuple[float, float]:
    """End of the servo [m] and mean tension along the path [N] where the servo pulls with `pull` [N].

    T' = -mu T k, EI k = r T, so the bend is log(1 + mu r T L / EI) / mu where it is pulled; let out, both signs change.
    """
    bend = sign * math.log1p(sign * coefficient * ARM * pull * ROD.length / ROD.bending_stiffness) / coefficient
    mean = ROD.bending_stiffness * bend / (ARM * ROD.length)
    shortening = ROD.length * mean / (ROD.youngs_modulus * ROD.area) + ARM * bend
    return shortening + mean / STIFFNESS, mean


@pytest.mark.parametrize("coefficient", [0.1, 0.2])
@pytest.mark.parametrize(("pull", "sign"), [(8.0, 1.0), (20.0, 1.0), (40.0, 1.0), (4.0, -1.0), (12.0, -1.0)])
def test_a_slow_pull_and_release_is_the_capstans_along_the_whole_path(
    coefficient: float, pull: float, sign: float
) -> None:
    run = loop(coefficient)
    end, mean = by_hand(pull, coefficient, sign)
    branch = slice(0, STEPS) if sign > 0.0 else slice(2 * STEPS - 1, STEPS - 1, -1)
    assert np.interp(end, run.end[branch], run.before[branch]) == pytest.approx(pull, rel=6e-3)
    assert np.interp(end, run.end[branch], run.behind[branch]) == pytest.approx(mean, rel=6e-3)


def test_without_friction_the_path_is_the_same_in_both_directions() -> None:
    run = loop(0.0)
    pulled, back = (np.interp(0.03, run.end[one], run.x[one]) for one in (slice(STEPS), slice(None, STEPS - 1, -1)))
    assert abs(pulled - back) < 2e-3 * pulled
    rubs = loop(COEFFICIENTS[-1])
    pulled, back = (np.interp(0.02, rubs.end[one], rubs.x[one]) for one in (slice(STEPS), slice(None, STEPS - 1, -1)))
    assert pulled - back > 0.03 * pulled  # bent more near the base while it is pulled
    np.testing.assert_allclose(run.before, run.behind, atol=1e-9)


def test_friction_is_of_the_general_rod_which_it_chooses() -> None:
    rig = parse_config(RIG, "rig").simulator
    assert plant_solver(rig) == "general"
    rod = plant_rod(rig, 0.01)
    assert isinstance(rod, GeneralPlantRod)
    assert [tendon.friction for tendon in rod.robot.tendons] == [rig.servo.friction] * 4


@pytest.mark.parametrize("table", [{"servo": {"friction": 0.1}}, {"rod": {"tendon_friction": 0.1}}])
def test_friction_on_the_shooting_rod_is_refused_with_the_remedy(table: dict[str, object]) -> None:
    def section(solver: Solver | None) -> SimulatorSection:
        return check_config({"simulator": {"solver": solver, **table}}, "test").simulator

    with pytest.raises(ParameterError, match=r"simulator\.solver = 'shooting': .*remove the key") as refused:
        plant_rod(section("shooting"), 0.01)
    assert "\n" not in str(refused.value)
    assert isinstance(plant_rod(section(None), 0.01), GeneralPlantRod)


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode"])
@pytest.mark.parametrize(("configured", "error_mm"), [(0.0, 2.0), (COEFFICIENTS[-1], 0.2)])
def test_the_laws_track_through_friction_closely_where_it_is_configured(
    law: str, configured: float, error_mm: float
) -> None:
    """Friction bends the rod more near its base: a model without it has no rest at the target's x and z."""
    row = run_rig(law, COEFFICIENTS[-1], configured)
    assert row.fault == ""
    assert row.settled is not None
    assert row.error_mm < error_mm


def test_the_table_in_the_docs_is_what_friction_does() -> None:
    """Renew it with `tendond bench friction`."""
    text = DOCS.read_text(encoding="utf-8")
    assert HEADING in text
    for coefficient in COEFFICIENTS[1:]:
        line = next(one for one in text.splitlines() if one.startswith(f"| {coefficient:g} | backstepping |"))
        servo, rod = (float(number) for number in re.findall(r"\d+\.\d+", line.split("|", 3)[3])[:2])
        run = loop(coefficient)
        assert servo == pytest.approx(run.before[STEPS - 1], abs=0.1)
        assert rod == pytest.approx(run.behind[STEPS - 1], abs=0.1)
