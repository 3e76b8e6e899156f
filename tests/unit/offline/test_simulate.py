"""Runs for notebooks: from any form of configuration, the same every time, with what was asked for in their logs."""

from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.errors import TargetError, UsageError
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.logs.stretches import stretches
from tendond.offline.simulate import simulate, simulate_excitation
from tendond.schemas.config.rig import ConfigError, check_config

TABLES = {"control": {"law": "sliding_mode"}, "simulator": {"mocap": {"noise": 1e-4}, "seed": 3}}


def test_a_run_tracks_from_arming_to_stopping_and_ends_slack(tmp_path: Path) -> None:
    run = simulate(TABLES, tmp_path / "run.mcap", seconds=1.0)
    (one,) = stretches(run)
    assert one.law == "sliding_mode"
    assert one.start + one.duration == pytest.approx(0.1 + 1.0)
    assert one.at_end < 0.1 * one.largest
    assert (run["command.tension"][-1] == 0.0).all()


def test_a_run_is_the_same_from_tables_an_object_and_a_file_and_replaces_a_log(tmp_path: Path) -> None:
    file, log = tmp_path / "rig.toml", tmp_path / "run.mcap"
    file.write_text('control.law = "sliding_mode"\nsimulator.mocap.noise = 1e-4\nsimulator.seed = 3\n')
    tips = [
        simulate(config, log, 0.5)["measured"] for config in (TABLES, check_config(TABLES, "test"), file, str(file))
    ]
    for tip in tips[1:]:
        np.testing.assert_array_equal(tip, tips[0])


def test_a_wrong_configuration_or_time_is_refused_before_a_log_is_replaced(tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    log.write_bytes(b"precious")
    with pytest.raises(ConfigError, match=r"control\.lav: unknown key; did you mean 'law'"):
        simulate({"control": {"lav": "x"}}, log)
    with pytest.raises(TargetError):
        simulate({"reference": {"across": 0.49}}, log)
    with pytest.raises(UsageError, match="must be > 0"):
        simulate({}, log, seconds=0.0)
    assert log.read_bytes() == b"precious"


def test_an_excitation_has_the_weight_that_hung_on_the_tip(tmp_path: Path) -> None:
    rig = {
        "limits": {"displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": 0.2},
        "simulator": {"drive": "displacement"},
    }
    free = simulate_excitation(rig, tmp_path / "free.mcap", ["steps"], 0.6)
    weighted = simulate_excitation(rig, tmp_path / "weighted.mcap", ["steps"], 0.6, 0.05)
    assert weighted["measured"][0, 0] < free["measured"][0, 0] - 0.05  # it sags
    assert [load_recording(tmp_path / name, {}).weight for name in ("free.mcap", "weighted.mcap")] == [0.0, 0.05]
