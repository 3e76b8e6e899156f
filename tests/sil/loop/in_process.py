"""Controller and plant in one process, without a clock, and a cycle that a test may replace."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh

from tendond.daemon.control.cycle import respond
from tendond.daemon.control.record import Response
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime import loop as loop_module
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.loop import Loop
from tendond.daemon.runtime.pacing import Wake
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import plant_rod
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.record import CycleInputs
from tests.sil.rig import Rig

Failing = Callable[[CycleState, CycleInputs], bool]


class PlantPacer:
    """Pacer with the plant in it: one cycle per pose."""

    def __init__(self, hub: Hub, plant: Plant) -> None:
        self._hub = hub
        self._plant = plant

    def wait(self) -> Wake:
        arrivals = self._hub.receive()
        arrivals.pose, arrivals.tendon_state, _ = self._plant.observe(0)
        if self._hub.last_command is not None:
            self._plant.step(self._hub.last_command)
        return Wake(time.monotonic(), arrivals, 0.0, 0)


class InProcess:
    """Loop on a bus of its own, armed in its fifth cycle.

    Attributes:
        rig: names and folder. config: configuration. session: a client's.
    """

    def __init__(self, rig: Rig, config: RigConfig, session: zenoh.Session, run: Callable[..., None]) -> None:
        self.rig, self.config, self.session = rig, config, session
        self._run = run

    def run(self, stopped: Callable[[], bool] = lambda: False) -> None:
        """Run the loop until stopped, or until it fails."""
        self._run(stopped)


@contextmanager
def in_process(
    folder: Path, patch: pytest.MonkeyPatch, failing: Failing, error: Exception, **tables: object
) -> Iterator[InProcess]:
    """Prepare a loop whose cycle fails.

    Args:
        folder: an empty one.
        patch: replaces the cycle.
        failing: whether the cycle of a state and inputs fails.
        error: with which it fails.
        tables: more of the configuration.
    """
    one = Rig(folder)
    config = check_config({"rig": {"name": one.name}, "bus": {"endpoint": one.endpoint}, **tables}, "test")
    setup = CycleSetup.from_config(config)

    def fail_or_respond(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Response:
        if failing(state, inputs):
            raise error
        return respond(setup, state, inputs)

    with Hub(config) as hub, RunLog(folder / "run.mcap", config, setup.rod) as run_log, one.session() as session:
        loop = Loop(setup, hub, run_log, arm_at=5)
        state = loop.warm()
        patch.setattr(loop_module, "respond", fail_or_respond)
        pacer = PlantPacer(hub, Plant(config, plant_rod(config.simulator, config.loop.period)))
        yield InProcess(one, config, session, lambda stopped: loop.run(state, pacer, stopped))
