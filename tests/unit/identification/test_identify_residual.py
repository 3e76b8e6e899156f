"""The learned correction: of a robot that the fit cannot describe, as [observer.residual]; none of one that it can."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from tendond.model.estimation.residual import residual_of
from tendond.offline.correction.learned import along
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.results.parameter_file import parameter_file
from tendond.offline.identification.results.residual import learn, summary
from tendond.schemas.config.rig import parse_config
from tests.unit.identification.recordings import TRUE, pulls_and_waits, recording

GRID = [(x, y, -x - 0.001, -y - 0.001) for x in np.linspace(-0.02, 0.02, 6) for y in np.linspace(-0.02, 0.02, 6)]
NOW = datetime(2026, 1, 2, tzinfo=UTC)


def test_what_a_fit_cannot_describe_is_learned_and_written_for_the_observer() -> None:
    bent = recording({**TRUE, "zero_1": 0.0015, "base_turn_z": -0.05}, moved=pulls_and_waits(GRID), general=True)
    result = identify([bent], [bent], Options(("E",), jobs=2))
    found = learn(result.simulations, result.others, result.fit.values)
    assert found.residual is not None
    assert found.after < 0.3 * found.before
    assert found.held_out[0][2] < 0.3 * found.held_out[0][1]
    assert "without" in summary(found)
    section = parse_config(parameter_file(result, NOW, found), "written").observer.residual
    assert section is not None
    commands = bent.command[:: len(bent.command) // 50]
    np.testing.assert_array_equal(along(residual_of(section), commands), along(found.residual, commands))


def test_a_robot_that_the_fit_describes_has_no_correction() -> None:
    right = recording(TRUE, moved=pulls_and_waits(GRID), general=True)
    result = identify([right], [], Options(("E", "rho"), jobs=2))
    found = learn(result.simulations, (), {**result.fit.values, **TRUE})
    assert found.residual is None
    assert summary(found).startswith("residual: none")
    assert "[observer.residual]" not in parameter_file(result, NOW, found)


def test_a_log_too_short_to_leave_something_out_has_none() -> None:
    right = recording(TRUE, moved=pulls_and_waits(GRID), general=True)
    result = identify([right], [], Options(("E",), jobs=2))
    only = result.simulations[0]
    only.recording = replace(only.recording, pose_times=only.recording.pose_times * 0.0 + only.recording.pose_times[0])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(type(only), "predicted_poses", lambda self, motion, delay: self.recording.position)
        found = learn([only], (), result.fit.values)
    assert found.residual is None
    assert "shorter than" in summary(found)
