"""Live tuning with real processes: asked for on the bus, shown, in the log, and replayed to the last bit."""

import json
from pathlib import Path

import pytest

from tendond.offline.logs.log import load
from tendond.offline.replay.rerun import rerun
from tendond.schemas.messages import Mode
from tests.sil.rig import rig

pytestmark = pytest.mark.sil

ALPHA1 = "control.laws.backstepping.alpha1"


def test_a_gain_is_tuned_while_the_arm_tracks_and_the_run_is_replayed_to_the_last_bit(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            one.arm(session)
            missed = one.status(session).loop.missed_ticks
            done = one.command("rig", "set", "alpha1=900", "limits.tension_max=55", "--unchecked")
            assert done.returncode == 0, done.stderr
            assert (
                done.stdout
                == f"{ALPHA1} = 900, from 1500 within 1.3 s; limits.tension_max = 55, from 60 within 0.5 s\n"
            )
            status = one.until(session, lambda s: ALPHA1 in s.tuned and s.tuned[ALPHA1].value == 900.0)
            assert status.mode is Mode.TRACKING
            assert status.loop.missed_ticks - missed < 5  # the checks were prepared before: cold they take ten cycles
            for shown, limit in (("status", "limits.tension_max = 55 (configured 60)"), ("watch --once", " of 55 N ")):
                page = one.command(*shown.split()).stdout
                assert "backstepping.alpha1 = 900" in page
                assert limit in page
            listed = json.loads(one.command("rig", "get", "--json").stdout)
            assert listed[ALPHA1]["value"] == 900.0
            assert listed["limits.tension_max"]["allowed"].endswith("and no more than configured [N]")
            for wrong, reason in (
                ("limits.tension_max=70", "must be 60 [N], the configuration's, or less"),
                ("limits.slack=0.001", "changes only while idle: the arm is tracking; run 'tendond stop"),
                ("alpha1=fast", "'alpha1=fast': give KEY=VALUE with a number"),
            ):
                refused = one.command("rig", "set", wrong)
                assert refused.returncode != 0
                assert reason in refused.stderr
            assert one.command("rig", "set", "--configured").returncode == 0
            one.until(session, lambda s: not s.tuned)
        one.end(one.started["simulate"])
        one.end(one.started["run"])
        log = tmp_path / "run.mcap"
        asked = [record for record in load(log).records if record.inputs.settings]
        assert asked[0].inputs.settings == {ALPHA1: 900.0, "limits.tension_max": 55.0}
        assert any(900.0 < record.tuned.get(ALPHA1, 0.0) < 1500.0 for record in load(log).records)
        outcome = rerun(log, jobs=1)
        assert outcome.compared > 100
        assert outcome.differing == 0, outcome.first
