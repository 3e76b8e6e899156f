"""The controller as a process against a plant, a camera and a tendon driver by others: documented messages only."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.sil.rig import rig

pytestmark = pytest.mark.sil

HOLD_CYCLES = 300
"""Cycles on the target, longer than the plant's summary covers."""

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("drive", ["tension", "displacement"])
def test_a_plant_by_others_is_tracked_in_real_time(drive: str, tmp_path: Path) -> None:
    extra = "[rod]\ntendon_stiffness = 20000.0\n[limits]\nslack = 0.002\n" if drive == "displacement" else ""
    with rig(tmp_path, extra) as one:
        one.controller()
        plant = subprocess.Popen(
            [sys.executable, "-m", "tests.plants.mujoco_rig", "--endpoint", one.endpoint, "--rig", one.name,
             "--drive", drive, "--noise", "1e-4"],
            cwd=ROOT, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        one.processes.append(plant)
        with one.session() as session:
            one.arm(session)
            one.until(session, lambda status: abs((status.tip or (0,))[0] - 0.34) < 3e-3)
            one.pass_ticks(session, HOLD_CYCLES)
            plant.send_signal(signal.SIGTERM)
            said, _ = plant.communicate(timeout=60.0)
        summary = json.loads(said.splitlines()[-1])
        assert summary["armed"], said
        assert summary["tip"][0] == pytest.approx(0.34, abs=3e-3)


def test_nothing_of_tendond_but_its_mujoco_plant_is_in_the_plant() -> None:
    """Neither the rod model nor schemas or bus: an error in those would be in both."""
    code = "import sys, tests.plants.mujoco_rig; print(*[name for name in sys.modules if name.startswith('tendond')])"
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True).stdout.split()
    assert [name for name in found if not name.startswith("tendond.drivers.mujoco")] == ["tendond", "tendond.drivers"]
