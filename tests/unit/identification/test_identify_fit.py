"""The fit: what it finds, what it refuses, how it goes on after an interruption."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.errors import UsageError
from tendond.offline.identification.configured import starts, with_values
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import chosen
from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.results.result import Identification
from tests.unit.identification.recordings import CONFIG, NAMES, TRUE, recording


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


def test_wrong_names_are_refused_by_name() -> None:
    with pytest.raises(UsageError, match="'mass': choose among E, rho, Bbt"):
        chosen(("E", "mass"))
    with pytest.raises(UsageError, match=r"rod\.drag = 0 is no start for a fit"):
        starts(with_values(CONFIG, {"C": 0.0}), chosen(("C",)))


def test_logs_that_tell_nothing_are_an_error(free: Recording) -> None:
    still = replace(free, position=np.tile(free.position[0], (len(free.position), 1)))
    with pytest.raises(DataError, match="no motion"):
        identify([still], [], Options(("E",)))
