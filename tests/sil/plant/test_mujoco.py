"""`tendond simulate --plant mujoco` as a process: tracked by the controller in real time, pushed by an injection."""

from pathlib import Path

import pytest

from tendond.offline.logs.log import load
from tendond.schemas.messages import Mode
from tests.sil.rig import rig

pytestmark = pytest.mark.sil


def test_the_mujoco_plant_is_tracked_by_real_processes_and_takes_injections(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        one.controller()
        one.start("simulate", "--plant", "mujoco")
        with one.session() as session:
            one.arm(session)
            one.until(session, lambda status: abs((status.tip or (0,))[0] - 0.34) < 2e-3)
            assert one.command("rig", "inject", "weight", "--size", "0.03").returncode == 0
            refused = one.command("rig", "inject", "crc")
            assert refused.returncode == 1
            assert "crc needs wires" in refused.stderr
            status = one.pass_ticks(session, 100)
            assert status.mode is Mode.TRACKING
        for command in ("simulate", "run"):
            assert one.end(one.started[command])[0] == 0
    log = load(tmp_path / "run.mcap")
    assert any("weight" in truth.injected for truth in log.truth)
