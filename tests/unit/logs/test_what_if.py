"""`tendond log what-if`: another law or parameter, on the recorded inputs or in the closed loop."""

from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.errors import UsageError
from tendond.offline.logs import load
from tendond.offline.logs.run import open_run
from tendond.offline.replay.changes import with_changes
from tendond.offline.replay.rerun import rerun
from tendond.offline.replay.variant import closed_loop, same_inputs
from tendond.schemas.config.rig import RigConfig
from tests.golden.scripts import CYCLES, FOLDER
from tests.unit.logs.commands import run_command

NORMAL = FOLDER / "normal.mcap"


def test_another_law_on_the_same_inputs_is_a_log_that_replays(recorded: Path, tmp_path: Path) -> None:
    config = with_changes(open_run(recorded).config, "sliding_mode", ["control.laws.sliding_mode.k=10"])
    found = same_inputs(recorded, config, tmp_path / "other.mcap", "control.law=sliding_mode")
    assert found.cycles == CYCLES
    assert found.tension_max > 1.0
    new, old = load(tmp_path / "other.mcap"), load(recorded)
    np.testing.assert_array_equal(new["inputs.pose.position"], old["inputs.pose.position"])
    assert "terms.surface" in new.names
    assert new.config.control.laws["sliding_mode"] == {"k": 10.0}
    assert new.metadata["replay_changes"] == "control.law=sliding_mode"
    assert rerun(tmp_path / "other.mcap").first is None


def test_nothing_changed_on_the_same_inputs_commands_the_same(recorded: Path, tmp_path: Path) -> None:
    found = same_inputs(recorded, open_run(recorded).config, tmp_path / "again.mcap", "")
    assert (found.tension_max, found.displacement_max, found.modes) == (0.0, 0.0, 0)


def test_the_closed_loop_run_again_is_the_recorded_one_unless_something_changes(tmp_path: Path) -> None:
    config = open_run(NORMAL).config
    first = closed_loop(NORMAL, config, tmp_path / "first.mcap", "")
    again = closed_loop(tmp_path / "first.mcap", config, tmp_path / "again.mcap", "")
    assert (again.tension_max, again.displacement_max, again.modes) == (0.0, 0.0, 0)
    assert first.cycles == again.cycles == CYCLES
    softer = with_changes(config, None, ["simulator.weight.mass=0.02"])
    found = closed_loop(tmp_path / "first.mcap", softer, tmp_path / "heavy.mcap", "")
    assert found.tension_max > 0.1
    assert load(tmp_path / "heavy.mcap")["truth.tip_force"][50, 0] < -0.1
    assert rerun(tmp_path / "heavy.mcap").first is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("alpha1=900", "give it as section.key=value"),
        ("limits.colour=1", "--set: limits.colour: unknown key"),
        ("limits.tension_max=-1", "--set: limits.tension_max = -1"),
        ("rig.name.x=1", "'name' is no section"),
    ],
)
def test_a_change_that_cannot_be_is_refused_in_one_line(change: str, message: str) -> None:
    with pytest.raises(UsageError) as caught:
        with_changes(RigConfig(), None, [change])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_parameter_of_the_law_in_use_needs_no_longer_name() -> None:
    assert with_changes(RigConfig(), None, ["control.alpha1=900"]).control.laws == {"backstepping": {"alpha1": 900.0}}
    other = with_changes(RigConfig(), "sliding_mode", ["control.k=10"])
    assert (other.control.law, other.control.laws) == ("sliding_mode", {"sliding_mode": {"k": 10.0}})
    said = run_command("log", "what-if", str(NORMAL), "--set", "control.colour=1")
    assert (said.returncode, said.stderr.count("\n")) == (2, 1)
    assert "colour" in said.stderr
