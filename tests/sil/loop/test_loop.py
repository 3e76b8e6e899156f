"""A cycle that fails as nobody foresaw: the last thing that leaves the process is a ramp to slack."""

import itertools
import threading
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import open_client
from tendond.daemon.control.cycle import respond
from tendond.daemon.control.state import CycleSetup
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime import loop as loop_module
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.loop import Loop
from tendond.drivers.simulator.plant import Plant
from tendond.offline.logs.log import load
from tendond.schemas.config.rig import check_config
from tendond.schemas.keys import TENDON_COMMAND, key
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction, ControlReply
from tendond.schemas.wire import decode
from tests.sil.pacer import PlantPacer
from tests.sil.rig import Rig

pytestmark = pytest.mark.sil

FAILING_CYCLE = 60


def test_a_crash_in_the_cycle_releases_the_tendons_along_a_ramp(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(setup: CycleSetup, state: object, inputs: object) -> object:
        if getattr(state, "tick") == FAILING_CYCLE:  # noqa: B009
            raise ZeroDivisionError("of all things")
        return respond(setup, state, inputs)  # type: ignore[arg-type]

    one = Rig(tmp_path)
    config = check_config(
        {
            "rig": {"name": one.name},
            "bus": {"endpoint": one.endpoint},
            "commissioning": {"rest": False, "probe": False},
        },
        "test",
    )
    setup = CycleSetup.from_config(config)
    with Hub(config) as hub, RunLog(tmp_path / "run.mcap", config, setup.rod) as run_log, one.session() as session:
        commands = session.declare_subscriber(key(one.name, TENDON_COMMAND), zenoh.handlers.FifoChannel(1000))
        loop = Loop(setup, hub, run_log, arm_at=5)
        state = loop.warm()
        monkeypatch.setattr(loop_module, "respond", failing)
        with pytest.raises(DaemonError, match="ZeroDivisionError: of all things"):
            loop.run(state, PlantPacer(hub, Plant(config, setup.rod)), lambda: False)
        received: list[TendonCommand] = []
        while not received or received[-1].armed or received[-1].seq < FAILING_CYCLE:
            received.append(decode(TendonCommand, commands.recv().payload.to_bytes()))
    commanded = next(command for command in reversed(received) if command.seq < FAILING_CYCLE)
    tensions = [command.tension[0] for command in received[received.index(commanded) :]]
    assert tensions[0] > 20.0
    assert tensions[-1] == 0.0
    step_down = config.limits.release_rate * config.loop.period
    assert all(0.0 <= a - b <= step_down + 1e-9 for a, b in itertools.pairwise(tensions))
    assert not received[-1].armed
    counts = [command.seq for command in received]
    assert all(late > early for early, late in itertools.pairwise(counts)), "a driver drops what does not count up"
    assert any("ZeroDivisionError" in line.message for line in load(tmp_path / "run.mcap").log_lines)


def test_a_request_that_the_cycle_cannot_take_is_answered_with_the_reason_and_the_loop_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(setup: CycleSetup, state: object, inputs: CycleInputs) -> object:
        if inputs.request is ControlAction.RESET:
            raise ZeroDivisionError("of all things")
        return respond(setup, state, inputs)  # type: ignore[arg-type]

    one = Rig(tmp_path)
    config = check_config(
        {
            "rig": {"name": one.name},
            "bus": {"endpoint": one.endpoint},
            "commissioning": {"rest": False, "probe": False},
        },
        "test",
    )
    setup = CycleSetup.from_config(config)
    replies: list[ControlReply] = []
    with Hub(config) as hub, RunLog(tmp_path / "run.mcap", config, setup.rod) as run_log, one.session() as session:
        loop = Loop(setup, hub, run_log, arm_at=5)
        state = loop.warm()
        monkeypatch.setattr(loop_module, "respond", failing)
        asker = threading.Thread(target=lambda: replies.append(one.ask(session, ControlAction.RESET)))
        asker.start()
        loop.run(state, PlantPacer(hub, Plant(config, setup.rod)), lambda: bool(replies))
        asker.join()
    assert not replies[0].done
    assert replies[0].message == "not done: ZeroDivisionError: of all things"
    log = load(tmp_path / "run.mcap")
    assert any("ZeroDivisionError" in line.message for line in log.log_lines)
    assert not any(record.inputs.request is ControlAction.RESET for record in log.records)
    assert log.records[-1].mode is Mode.IDLE


def test_a_client_without_a_controller_gives_up_when_asked(tmp_path: Path) -> None:
    from tendond.bus.client import StoppedError

    with pytest.raises(StoppedError):
        open_client(Rig(tmp_path).endpoint, 60.0, lambda: True)
