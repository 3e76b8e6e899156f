"""A body on the tip in the fit: found beside a known weight, a ratio without a known force."""

import tomllib
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tendond.model.rod.tip_body import ball_inertia
from tendond.offline.identification.configured import with_values
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.results.parameter_file import parameter_file
from tendond.offline.identification.results.report import report
from tendond.offline.identification.simulation.simulate import Simulation
from tests.unit.identification.recordings import CONFIG, NAMES, TRUE, recording

TOOL = {**TRUE, "tip_mass": 0.03}
FORCES = ("E", "rho", "Bbt", "tendon_stiffness", "tip_mass", "delay")
SMALL = (0.02, 0.01, 0.025)


@pytest.fixture(scope="module")
def tool() -> Recording:
    """A recording of a rig with 30 g on its tip that are not in its configuration."""
    return recording(TOOL)


def test_a_known_weight_is_a_body_with_the_inertia_of_a_ball(free: Recording) -> None:
    mass = 0.04
    ball = CONFIG.model_copy(update={"rod": CONFIG.rod.model_copy(update={"tip_inertia": ball_inertia(mass)})})
    hung = Simulation(replace(free, weight=mass), "measured").motion(TRUE)
    own = Simulation(replace(free, config=ball), "measured").motion({**TRUE, "tip_mass": mass})
    assert np.abs(hung.tips - own.tips).max() < 1e-7


def test_a_body_on_the_tip_is_found_beside_a_known_weight(tool: Recording) -> None:
    weighted = recording(TOOL, seed=1, weight=0.04, levels=SMALL)
    result = identify([tool, weighted], [], Options((*NAMES, "tip_mass")))
    found = {one.parameter.name: one for one in result.parameters}
    one = found["tip_mass"]
    assert one.found
    assert abs(one.value - 0.03) <= 2.0 * one.error
    assert one.value == pytest.approx(0.03, rel=0.03)
    assert 0.0 < one.error < 2e-4
    assert result.values["E"] == pytest.approx(TRUE["E"], rel=0.01)
    assert result.values["rho"] == pytest.approx(TRUE["rho"], rel=0.01)
    text = parameter_file(result, datetime(2026, 1, 2, tzinfo=UTC))
    assert tomllib.loads(text)["rod"]["tip_mass"] == pytest.approx(one.value, rel=1e-5)
    assert "| tip_mass | kg | 0 | 0.0" in report(result, "file.toml")
    believed = with_values(CONFIG, result.values)
    assert believed.rod.tip_mass == one.value


def test_a_bare_tip_is_found_to_be_bare(free: Recording, weighted: Recording) -> None:
    result = identify([free, weighted], [], Options((*NAMES, "tip_mass")))
    found = {one.parameter.name: one for one in result.parameters}
    assert found["tip_mass"].found
    assert found["tip_mass"].value <= 2.0 * found["tip_mass"].error < 2e-4
    for name in ("E", "rho", "tendon_stiffness"):
        assert abs(found[name].value - TRUE[name]) <= 4.0 * found[name].error
    assert result.rms == pytest.approx(1e-4, rel=0.03), "a bound keeps the others from their best values"


def test_a_body_on_the_tip_without_a_known_force_is_a_ratio(tool: Recording) -> None:
    result = identify([tool], [], Options(FORCES))
    assert set(result.values) == {"delay"}
    ratios = {one.name: one for one in result.ratios}
    assert ratios["tip_mass/E"].value == pytest.approx(0.03 / TRUE["E"], rel=0.03)
    assert 0.0 < ratios["tip_mass/E"].error < 0.01 * ratios["tip_mass/E"].value
    assert "tip_mass/E = " in parameter_file(result, datetime(2026, 1, 2, tzinfo=UTC))


def test_a_ratio_of_nothing_is_reported_as_such(free: Recording) -> None:
    result = identify([free], [], Options(FORCES))
    (ratio,) = [one for one in result.ratios if one.name == "tip_mass/E"]
    assert ratio.value <= 2.0 * ratio.error
    assert "| tip_mass/E | | 0 |" in report(replace(result, ratios=(replace(ratio, value=0.0),)), "file.toml")


def test_one_and_the_same_weight_in_every_log_hides_a_body_on_the_tip(weighted: Recording) -> None:
    result = identify([weighted], [], Options(FORCES))
    found = {one.parameter.name: one for one in result.parameters}
    assert "add a log without it" in found["tip_mass"].why
    assert result.fit.values["tip_mass"] == 0.0, "the configuration's value, not where a fit would start"
    assert "which these logs cannot check" in result.scale
    assert found["E"].value == pytest.approx(TRUE["E"], rel=0.01)


def test_a_body_on_the_tip_that_is_not_fitted_fixes_the_scale(tool: Recording) -> None:
    known = replace(tool, config=with_values(CONFIG, {"tip_mass": 0.03, "C": TRUE["C"]}))
    result = identify([known], [], Options(("E", "rho", "Bbt", "tendon_stiffness", "delay")))
    assert result.values["E"] == pytest.approx(TRUE["E"], rel=0.01)
    assert "all others are relative to rod.tip_mass = 0.03" in result.scale
