"""A cycle that fails unexpectedly: the last thing that leaves the process is a ramp to slack."""

import itertools
import threading
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import open_client
from tendond.daemon.errors import DaemonError
from tendond.offline.logs.log import load
from tendond.schemas.keys import TENDON_COMMAND, key
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.requests import ControlAction, ControlReply
from tendond.schemas.wire import decode
from tests.sil.loop.in_process import in_process
from tests.sil.rig import Rig

pytestmark = pytest.mark.sil

FAILING_CYCLE = 60
AT_ONCE = {"rest": False, "probe": False}


def test_a_crash_in_the_cycle_releases_the_tendons_along_a_ramp(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    error = ZeroDivisionError("of all things")
    with in_process(
        tmp_path, monkeypatch, lambda state, _: state.tick == FAILING_CYCLE, error, commissioning=AT_ONCE
    ) as one:
        commands = one.session.declare_subscriber(key(one.rig.name, TENDON_COMMAND), zenoh.handlers.FifoChannel(1000))
        with pytest.raises(DaemonError, match="ZeroDivisionError: of all things"):
            one.run()
        received: list[TendonCommand] = []
        while not received or received[-1].armed or received[-1].seq < FAILING_CYCLE:
            received.append(decode(TendonCommand, commands.recv().payload.to_bytes()))
    commanded = next(command for command in reversed(received) if command.seq < FAILING_CYCLE)
    tensions = [command.tension[0] for command in received[received.index(commanded) :]]
    assert tensions[0] > 20.0
    assert tensions[-1] == 0.0
    step_down = one.config.limits.release_rate * one.config.loop.period
    assert all(0.0 <= a - b <= step_down + 1e-9 for a, b in itertools.pairwise(tensions))
    assert not received[-1].armed
    counts = [command.seq for command in received]
    assert all(late > early for early, late in itertools.pairwise(counts)), "a driver drops what does not count up"
    assert any("ZeroDivisionError" in line.message for line in load(tmp_path / "run.mcap").log_lines)


def test_a_request_that_fails_in_the_cycle_has_the_reason_as_reply_and_the_loop_continues(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replies: list[ControlReply] = []
    error = ZeroDivisionError("of all things")
    with in_process(
        tmp_path, monkeypatch, lambda _, inputs: inputs.request is ControlAction.RESET, error, commissioning=AT_ONCE
    ) as one:
        asker = threading.Thread(target=lambda: replies.append(one.rig.ask(one.session, ControlAction.RESET)))
        asker.start()
        one.run(lambda: bool(replies))
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
