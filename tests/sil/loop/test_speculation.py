"""Speculation gives the same as a cycle after its deadline, and is not used once more input comes."""

import time
from pathlib import Path

import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.loop import Loop
from tendond.daemon.runtime.pacing import Wake
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import plant_rod
from tendond.offline.logs.log import LogFile, load
from tendond.schemas.config.rig import RigConfig, check_config
from tests.sil.rig import Rig

pytestmark = pytest.mark.sil

CYCLES, ARM_AT = 90, 8


class Speculating:
    """A pacer with the plant in it; by turns all has come before the speculation, half, nothing, or a tick is missed.

    Args:
        hub: of the loop. plant: in the loop. speculate: whether to.
    """

    def __init__(self, hub: Hub, plant: Plant, *, speculate: bool) -> None:
        self._hub, self._plant, self._speculate = hub, plant, speculate
        self._tick = -1
        self.loop: Loop | None = None

    def wait(self) -> Wake:
        self._tick += 1
        if self._hub.last_command is not None:
            self._plant.step(self._hub.last_command)
        pose, tendons, _ = self._plant.observe(0)
        turn = self._tick % 4
        arrivals = Arrivals()
        if turn in (0, 3):
            arrivals.pose, arrivals.tendon_state, arrivals.inputs = pose, tendons, 2
        elif turn == 1:
            arrivals.pose, arrivals.inputs = pose, 1
        if self._speculate:
            assert self.loop is not None
            self.loop.speculate(arrivals)
        if turn == 1:
            arrivals.tendon_state, arrivals.inputs = tendons, 2
            arrivals.unreadable["malformed"] = 1
        elif turn == 2:
            arrivals.pose, arrivals.tendon_state, arrivals.inputs = pose, tendons, 2
        return Wake(time.monotonic(), arrivals, 0.0, int(turn == 3), 1e-4)


def run(path: Path, config: RigConfig, *, speculate: bool) -> LogFile:
    setup = CycleSetup.from_config(config)
    with Hub(config) as hub, RunLog(path, config, setup.rod) as run_log:
        pacer = Speculating(hub, Plant(config, plant_rod(config.simulator, config.loop.period)), speculate=speculate)
        pacer.loop = Loop(setup, hub, run_log, arm_at=ARM_AT)
        pacer.loop.run(pacer.loop.warm(), pacer, lambda: False, CYCLES)
    return load(path)


def test_a_speculative_run_is_the_same_to_the_last_bit_and_is_used_where_nothing_came_after(tmp_path: Path) -> None:
    one = Rig(tmp_path)
    tables = {"rig": {"name": one.name}, "bus": {"endpoint": one.endpoint}, "commissioning": {"probe": False}}
    config = check_config(tables, "test")
    plain = run(tmp_path / "plain.mcap", config, speculate=False)
    speculative = run(tmp_path / "speculative.mcap", config, speculate=True)
    assert [r.model_dump_json() for r in speculative.records] == [r.model_dump_json() for r in plain.records]
    assert max(record.command.tension[0] for record in speculative.records) > 1.0
    assert not any(timing.ahead for timing in plain.timings)
    assert [timing.tick for timing in speculative.timings if timing.ahead] == [
        tick for tick in range(CYCLES) if tick % 4 == 0 and tick != ARM_AT
    ]
