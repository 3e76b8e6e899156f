"""The fit: what it finds, what it refuses, how it goes on after an interruption."""

import tomllib
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tendond.daemon.errors import UsageError
from tendond.model.rod.tip_body import ball_inertia
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.fitting.solve import bounded_step
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import chosen, nominal, starts, with_values
from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.results.parameter_file import parameter_file
from tendond.offline.identification.results.report import report
from tendond.offline.identification.results.result import Identification
from tendond.offline.identification.simulation.simulate import Simulation
from tests.unit.identification.recordings import CONFIG, TRUE, recording

NAMES = ("E", "rho", "Bbt", "C", "tendon_stiffness", "delay", "lag")
TOOL = {**TRUE, "tip_mass": 0.03}
FORCES = ("E", "rho", "Bbt", "tendon_stiffness", "tip_mass", "delay")
SMALL = (0.02, 0.01, 0.025)


@pytest.fixture(scope="module")
def free() -> Recording:
    return recording()


@pytest.fixture(scope="module")
def weighted() -> Recording:
    return recording(seed=1, weight=0.04, levels=(0.02, 0.01, 0.025))


@pytest.fixture(scope="module")
def tool() -> Recording:
    """A recording of a rig with 30 g on its tip that are not in its configuration."""
    return recording(TOOL)


@pytest.fixture(scope="module")
def found(free: Recording, weighted: Recording) -> Identification:
    """All of them, with a known weight."""
    held_out = recording(seed=2, levels=(0.02, 0.035, 0.02))
    return identify([free, weighted], [held_out], Options(NAMES))


def test_with_a_known_weight_everything_is_found_within_its_errors(found: Identification) -> None:
    assert all(one.found for one in found.parameters)
    for one in found.parameters:
        off = one.value - TRUE[one.parameter.name]
        if one.parameter.name == "lag":  # the reports were made without noise: no error to hold it to
            assert off == pytest.approx(0.0, abs=1e-5)
        else:
            assert abs(off) <= 4.0 * one.error, one.parameter.name
    assert found.values["E"] == pytest.approx(TRUE["E"], rel=0.02)
    assert found.scale == "the known weight on the tip: 40 g"
    assert found.rms == pytest.approx(1e-4, rel=0.1)


def test_on_a_log_that_was_not_used_the_identified_model_is_nearer(found: Identification) -> None:
    (held_out,) = [one for one in found.held_out if not one.used]
    assert held_out.fitted_rms < 0.2 * held_out.nominal_rms
    assert held_out.fitted_rms == pytest.approx(np.sqrt(3.0) * 1e-4, rel=0.1)


def test_without_a_known_force_only_ratios_are_reported(free: Recording) -> None:
    result = identify([free], [], Options(("E", "rho", "Bbt", "tendon_stiffness", "delay")))
    found = {one.parameter.name: one for one in result.parameters}
    assert [name for name, one in found.items() if one.found] == ["delay"]
    assert "without a known force" in found["rho"].why
    assert set(result.values) == {"delay"}
    ratios = {one.name: one for one in result.ratios}
    assert set(ratios) == {"rho/E", "Bbt/E", "tendon_stiffness/E"}
    assert ratios["rho/E"].value == pytest.approx(TRUE["rho"] / TRUE["E"], rel=0.01)
    assert "displacements and poses fix only ratios" in result.scale
    assert "known weight" in result.scale


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


def test_a_step_to_a_bound_is_the_best_one_there() -> None:
    random = np.random.default_rng(3)
    jacobian, residuals = random.standard_normal((40, 3)), random.standard_normal(40)
    jacobian[:, 1] += 3.0 * jacobian[:, 0]
    residuals += jacobian[:, 0]
    low, high = np.array([-0.01, -1.0, -1.0]), np.ones(3)
    best = lsq_linear(jacobian, -residuals, bounds=(low, high), tol=1e-14).x
    assert best[0] == pytest.approx(-0.01), "a bound is active"
    assert bounded_step(jacobian, residuals, low, high) == pytest.approx(best, abs=1e-6)


def test_a_density_that_was_measured_otherwise_fixes_the_scale(free: Recording) -> None:
    known = replace(free, config=with_values(CONFIG, {"rho": TRUE["rho"], "C": TRUE["C"]}))
    result = identify([known], [], Options(("E", "Bbt", "tendon_stiffness", "delay")))
    assert result.values["E"] == pytest.approx(TRUE["E"], rel=0.02)
    assert "rho, which is not fitted" in result.scale


def test_the_servos_load_fixes_the_scale(free: Recording) -> None:
    random = np.random.default_rng(5)
    loaded = replace(free, pulled=np.maximum(0.0, free.pulled + 0.2 * random.standard_normal(free.pulled.shape)))
    result = identify([loaded], [], Options(("E", "rho", "Bbt", "tendon_stiffness", "delay"), load_noise=0.2))
    assert result.values["E"] == pytest.approx(TRUE["E"], rel=0.05)
    assert "servos' load" in result.scale


def test_what_the_data_cannot_tell_is_named_and_left_at_the_configurations_value(weighted: Recording) -> None:
    # Slow motion with a weight: the drag, a hundredth of the noise, is not identifiable.
    blind = replace(weighted, config=with_values(CONFIG, {"C": 1e-4}))
    result = identify([blind], [], Options(("E", "C", "delay")))
    found = {one.parameter.name: one for one in result.parameters}
    assert not found["C"].found
    assert found["C"].why
    assert found["E"].found
    assert result.fit.values["C"] == 1e-4
    assert {parameter.name for parameter in result.fit.parameters} == {"E", "delay"}


def test_commands_do_where_the_servos_report_nothing() -> None:
    silent = [recording(reports=False), recording(seed=1, weight=0.04, levels=(0.02, 0.01, 0.025), reports=False)]
    result = identify(silent, [], Options(NAMES))
    assert result.drive == "command"
    assert result.values["lag"] == pytest.approx(TRUE["lag"], abs=5e-4)
    assert result.values["delay"] == pytest.approx(TRUE["delay"], abs=5e-4)
    assert result.values["E"] == pytest.approx(TRUE["E"], rel=0.02)


def test_a_robust_loss_bears_poses_that_are_far_off(free: Recording, weighted: Recording) -> None:
    position = free.position.copy()
    position[::15] += 0.02
    # What is not fitted is right: then only the wild poses lead astray.
    known = with_values(CONFIG, {"C": TRUE["C"], "tendon_stiffness": TRUE["tendon_stiffness"]})
    wild, weighted = replace(free, position=position, config=known), replace(weighted, config=known)
    names = ("E", "rho", "Bbt", "delay")
    plain = identify([wild, weighted], [], Options(names)).values
    robust = identify([wild, weighted], [], Options(names, loss="huber")).values
    off = {name: abs(values["rho"] / TRUE["rho"] - 1.0) for name, values in (("plain", plain), ("robust", robust))}
    assert off["robust"] < 0.3 * off["plain"]


def test_an_interrupted_fit_goes_on_where_it_was_and_ends_at_the_same_bits(
    tmp_path: Path, free: Recording, weighted: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    options = Options(("E", "rho", "delay"))
    whole = identify([free, weighted], [], options, memory=tmp_path / "whole")
    assert not (tmp_path / "whole").exists()
    folder = tmp_path / "state"
    made: list[Any] = []
    honest = FitProblem.jacobian

    def counted(self: FitProblem, at: Any) -> Any:
        if len(made) == 2:
            raise KeyboardInterrupt
        made.append(at)
        return honest(self, at)

    monkeypatch.setattr(FitProblem, "jacobian", counted)
    with pytest.raises(KeyboardInterrupt):
        identify([free, weighted], [], options, memory=folder)
    assert list(folder.rglob("jacobian-*.npy"))

    def noted(self: FitProblem, at: Any) -> Any:
        made.append(at)
        return honest(self, at)

    monkeypatch.setattr(FitProblem, "jacobian", noted)
    resumed = identify([free, weighted], [], options, memory=folder)
    assert resumed.fit.coordinates.tobytes() == whole.fit.coordinates.tobytes()
    assert len({at.tobytes() for at in made}) == len(made), "a derivative was computed twice"
    assert not folder.exists()


def test_another_fit_does_not_take_over_what_this_one_has_kept(tmp_path: Path) -> None:
    at = np.zeros(2)
    one, other = EvaluationCache(tmp_path, {"a": 1}), EvaluationCache(tmp_path, {"a": 2})
    one.get("residuals", at, lambda: np.ones(3))
    assert one.get("residuals", at, lambda: np.zeros(3)).tolist() == [1.0, 1.0, 1.0]
    assert other.get("residuals", at, lambda: np.zeros(3)).tolist() == [0.0, 0.0, 0.0]


def test_threads_and_their_number_make_no_difference(free: Recording) -> None:
    rows = [
        FitProblem(
            [Simulation(free, "measured")], chosen(("E", "delay")), starts(CONFIG, chosen(("E", "delay"))), None, jobs,
            lambda what, done, total: None,
        ).jacobian(np.zeros(2)).tobytes()
        for jobs in (1, 3)
    ]  # fmt: skip
    assert rows[0] == rows[1]


def test_derivatives_of_the_delay_are_those_of_its_definition(free: Recording) -> None:
    simulation, values = Simulation(free, "measured"), {**nominal(CONFIG), "delay": 0.012}
    motion = simulation.motion(values)
    step = (simulation.predicted_poses(motion, 0.013) - simulation.predicted_poses(motion, 0.011)) / 0.002
    speed = np.gradient(simulation.predicted_poses(motion, 0.012), 0.01, axis=0)
    assert np.abs(step + speed).max() < 0.1 * np.abs(speed).max()


def test_wrong_names_are_refused_by_name() -> None:
    with pytest.raises(UsageError, match="'mass': choose among E, rho, Bbt"):
        chosen(("E", "mass"))
    with pytest.raises(UsageError, match=r"rod\.drag = 0 is no start for a fit"):
        starts(with_values(CONFIG, {"C": 0.0}), chosen(("C",)))


def test_logs_that_tell_nothing_are_an_error(free: Recording) -> None:
    still = replace(free, position=np.tile(free.position[0], (len(free.position), 1)))
    with pytest.raises(DataError, match="no motion"):
        identify([still], [], Options(("E",)))
