"""The log of a controller on the clock replays to the last bit, even if it was killed."""

import time
from pathlib import Path

import pytest

from tendond.offline.replay.rerun import rerun
from tests.sil.rig import rig

pytestmark = pytest.mark.sil


@pytest.mark.parametrize("killed", [False, True])
def test_a_live_run_replays_to_the_last_bit(tmp_path: Path, killed: bool) -> None:
    with rig(tmp_path) as one:
        controller = one.controller()
        one.start("simulate")
        with one.session() as session:
            one.arm(session)
            time.sleep(2.0)
        if killed:
            controller.kill()
            controller.communicate()
        else:
            assert one.end(controller)[0] == 0
    outcome = rerun(tmp_path / "run.mcap")
    assert (outcome.first, outcome.gaps.missing, outcome.complete) == (None, [], not killed)
    assert outcome.compared > 100
    assert rerun(tmp_path / "run.mcap", first=outcome.compared // 2).first is None
