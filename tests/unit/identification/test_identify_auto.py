"""Parameters that the logs support are chosen, and no others; each rig differs from its configuration in one thing."""

from collections.abc import Mapping

import pytest

from tendond.offline.identification.configured import nominal
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.results.report import report
from tendond.offline.identification.results.result import Identification
from tests.unit.identification.recordings import CONFIG, POSES, TRUE, pulls_and_waits, recording

BELIEVED = {**nominal(CONFIG), "lag": 0.02, "delay": 0.01}
"""The configuration's values; the servos' lag, which rests do not show, spares the tendons jerks that free friction."""


def selected(**wrong: float) -> tuple[dict[str, float], Identification]:
    """Select at the rests of a rig in motion, which differs from its configuration."""
    true = {**BELIEVED, **wrong}
    made = recording(true, moved=pulls_and_waits(POSES), general=True, step=0.0025)
    return true, identify([made], [], Options(None, jobs=2))


def names(result: Identification) -> set[str]:
    return {trial.name for trial in result.trials if trial.taken}


def test_of_a_rig_as_configured_nothing_is_changed() -> None:
    _, result = selected()
    assert names(result) == set()
    assert result.values == {}
    assert result.rms == pytest.approx(result.noise, rel=0.3)
    text = report(result, "identified.toml")
    assert "| base_rotation | +" in text
    assert "no support" in text


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        ({"mu": 0.15}, {"mu"}),
        ({"base_turn_y": 0.03, "base_turn_z": -0.05}, {"base_rotation"}),
        ({"base_x": 0.003, "zero_1": 0.0015, "mu": 0.1}, {"base_position", "zeros", "mu"}),
    ],
)
def test_what_is_wrong_is_chosen_and_found(wrong: Mapping[str, float], expected: set[str]) -> None:
    true, result = selected(**wrong)
    assert names(result) == expected
    for name in wrong:
        error = next(one.error for one in result.parameters if one.parameter.name == name)
        assert result.values[name] == pytest.approx(true[name], abs=3.0 * error), name
    refused = {trial.name: trial.why for trial in result.trials if not trial.taken}
    assert refused["lag"] == "rests do not depend on it: record motion"
    assert refused["rho"].startswith("held: it fixes the scale of force")
    assert all(refused.values())


def test_what_another_parameter_explains_is_said_to_be_like_it() -> None:
    """A robot whose tendons are softer, and nearer to the backbone, moves less in much the same way."""
    _, result = selected(mu=0.15)
    why = {trial.name: trial.why for trial in result.trials}
    assert any("not told apart from mu" in text for text in why.values())


def test_in_motion_a_late_camera_is_chosen() -> None:
    late = {**nominal(CONFIG), "lag": TRUE["lag"], "delay": 0.012}
    config = CONFIG.model_copy(update={"observer": CONFIG.observer.model_copy(update={"lag": TRUE["lag"]})})
    result = identify([recording(late, config=config, general=True, step=0.0025)], [], Options(None, jobs=2))
    assert not result.statics
    assert names(result) == {"delay"}
    assert result.values["delay"] == pytest.approx(0.012, abs=2e-4)
