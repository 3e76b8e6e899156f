"""The law `policy`: its file, what it asks for, and the loop and its limits behind it."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendond.cli.common import load_config
from tendond.daemon.control.laws import LAWS, SpatialObservation, select_law
from tendond.daemon.control.laws.policy import KINEMATIC, Parameters, Terms, decide
from tendond.daemon.errors import LawError
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.offline.learning.policy_file import read_policy, save_policy
from tendond.schemas.config.rig import ConfigError, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

TENDONS = 4


def pulling(outputs: list[float]) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return a policy that asks for the same whatever it sees."""
    return [
        (np.ones((3, KINEMATIC + TENDONS)), np.zeros(3)),
        (np.zeros((TENDONS, 3)), np.arctanh(np.array(outputs))),
    ]


def written(folder: Path, outputs: list[float], rate: float = 200.0) -> Path:
    path = folder / "policy.npz"
    save_policy(path, pulling(outputs), length=0.5, tension=60.0, rate=rate)
    return path


def test_a_file_comes_back_as_it_was_written(tmp_path: Path) -> None:
    layers = [(np.random.default_rng(1).normal(size=(TENDONS, KINEMATIC + TENDONS)), np.arange(4.0))]
    save_policy(tmp_path / "p.npz", layers, length=0.5, tension=60.0, rate=100.0)
    found = Parameters.model_validate(read_policy(tmp_path / "p.npz"))
    assert np.array_equal(found.matrices[0][0], layers[0][0])
    seen = np.arange(16.0)
    scale = np.array([0.5] * 12 + [60.0] * 4)
    assert found.act(seen) == pytest.approx(np.tanh(layers[0][0] @ (seen / scale) + layers[0][1]))


def test_it_asks_for_rates_of_the_present_tensions(tmp_path: Path) -> None:
    parameters = Parameters.model_validate(read_policy(written(tmp_path, [0.5, 0.0, -0.5, 0.0])))
    zero = np.zeros(3)
    seen = SpatialObservation(zero, zero, np.array([0.1, 0.0, 0.0]), zero, np.full(4, 5.0), 0.01, None)
    found = decide(parameters, seen)
    assert found.tension == pytest.approx([6.0, 5.0, 4.0, 5.0])
    assert isinstance(found.terms, Terms)
    assert found.terms.error == (0.1, 0.0, 0.0)


def test_the_limits_of_a_command_come_after_it(tmp_path: Path) -> None:
    """A policy that pulls all it can, for ever."""
    limits = {"tension_max": 8.0, "tension_rate": 50.0}
    table: dict[str, Any] = read_policy(written(tmp_path, [0.999, -0.999, -0.999, -0.999], 1e4))
    config = check_config(
        {"control": {"law": "policy", "laws": {"policy": table}}, "limits": limits, "reference": {"across": 0.08}},
        "test",
    )
    records = list(closed_loop(config, 120, {5: ControlAction.ARM}))
    tension = np.array([record.command.tension for record in records])
    tracking = [record for record in records if record.mode is Mode.TRACKING]
    assert len(tracking) > 10
    assert max(max(record.wanted or (0.0,)) for record in tracking) > 50.0
    assert tension.max() <= 8.0
    assert tension.min() >= 0.0
    assert np.abs(np.diff(tension, axis=0)).max() <= 50.0 * config.loop.period * (1.0 + 1e-9)


def test_a_configuration_has_the_weights_of_the_file_that_it_names(tmp_path: Path) -> None:
    written(tmp_path, [0.1, 0.0, 0.0, 0.0])
    rig = tmp_path / "rig.toml"
    rig.write_text('[control]\nlaw = "policy"\n[control.laws.policy]\nfile = "policy.npz"\nrate = 50.0\n')
    config = load_config(rig)
    law, parameters = select_law(config.control.law, config.control.laws)
    assert law.name == "policy"
    assert parameters.rate == 50.0
    assert len(parameters.layers) == 2


@pytest.mark.parametrize("content", [b"", b"no archive", b"PK\x03\x04 no archive"])
def test_a_file_that_is_no_policy_is_refused_in_a_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "policy.npz").write_bytes(content)
    with pytest.raises(ConfigError, match=r"policy\.npz: is not a policy: must be a NumPy archive") as caught:
        read_policy(tmp_path / "policy.npz")
    assert "\n" not in str(caught.value)


def test_a_policy_of_another_robot_is_refused(tmp_path: Path) -> None:
    layers = [(np.zeros((3, KINEMATIC + 3)), np.zeros(3))]
    save_policy(tmp_path / "policy.npz", layers, length=0.5, tension=60.0, rate=100.0)
    rig = tmp_path / "rig.toml"
    rig.write_text('[control]\nlaw = "policy"\n[control.laws.policy]\nfile = "policy.npz"\n')
    with pytest.raises(ConfigError, match="has 3 outputs, but the robot has 4 tendons"):
        load_config(rig)


def test_without_a_file_it_is_refused_and_it_is_not_among_the_laws_to_choose() -> None:
    with pytest.raises(LawError, match=r"control\.laws\.policy.*no policy: name the file of a trained one"):
        select_law("policy", {})
    assert "policy" not in list(LAWS)
    assert "policy" in LAWS
