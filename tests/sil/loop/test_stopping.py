"""Stopping, and what must not stop it: requests in every mode, a slow release, a wall clock that jumps."""

import itertools
import os
import signal
import subprocess
from pathlib import Path

import pytest
import zenoh
from mcap.records import Message

from tendond.daemon.control.phases.modes import ACTIVE
from tendond.offline.logs.container import records as read_records
from tendond.offline.logs.log import load
from tendond.schemas.keys import TENDON_COMMAND, key
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.requests import ControlAction
from tendond.schemas.wire import decode
from tests.sil.rig import rig

pytestmark = pytest.mark.sil

SLOW = """
[limits]
release_rate = 20.0
[pretension]
duration = 1.5
"""


def test_stop_is_heard_in_every_mode_and_acts_in_the_cycle_that_hears_it(tmp_path: Path) -> None:
    with rig(tmp_path, SLOW) as one:
        controller, simulator = one.controller(), one.start("simulate")
        with one.session() as session:

            def stop() -> tuple[Mode, str]:
                reply = one.ask(session, ControlAction.STOP)
                assert reply.done
                assert reply.status is not None
                return reply.status.mode, reply.message

            one.until(session, lambda s: s.tip is not None)
            assert stop() == (Mode.IDLE, "nothing to stop: idle")
            assert one.ask(session, ControlAction.ARM).done
            one.until(session, lambda s: s.mode is Mode.PRETENSION)
            assert stop() == (Mode.RELEASING, "stopped: releasing the tendons")
            one.until(session, lambda s: s.mode is Mode.IDLE)
            one.arm(session)
            one.until(session, lambda s: s.tension[0] > 20.0)
            assert stop() == (Mode.RELEASING, "stopped: releasing the tendons")
            assert stop() == (Mode.RELEASING, "nothing to stop: releasing")
            one.until(session, lambda s: s.mode is Mode.IDLE)
            one.arm(session)
            simulator.kill()
            one.until(session, lambda s: s.mode is Mode.FAULT)
            assert stop() == (Mode.FAULT, "in fault: the tendons are released already")
        assert one.end(controller)[0] == 0
    records = load(tmp_path / "run.mcap").records
    stops = [record for record in records if record.inputs.request is ControlAction.STOP]
    assert len(stops) == 5
    assert not any(record.mode in ACTIVE for record in stops)


def test_a_release_that_takes_too_long_is_cut_short_after_sigterm(tmp_path: Path) -> None:
    """Forty newtons at one a second: after four of them the last command goes out all the same."""
    with rig(tmp_path, "[limits]\nrelease_rate = 1.0\n") as one:
        controller, _ = one.controller(), one.start("simulate")
        with one.session() as session:
            one.arm(session)
            one.until(session, lambda s: s.tension[0] > 20.0)
            commands = session.declare_subscriber(key(one.name, TENDON_COMMAND), zenoh.handlers.FifoChannel(1000))
            code, said = one.end(controller, signal.SIGTERM)
            assert code == 0, said
            heard: list[TendonCommand] = []
            while not heard or heard[-1].armed:
                heard.append(decode(TendonCommand, commands.recv().payload.to_bytes()))
    assert heard[-1].tension == heard[-1].displacement == (0.0,) * 4
    records = load(tmp_path / "run.mcap").records
    releasing = [record.tick for record in records if record.mode is Mode.RELEASING]
    assert 0 < len(releasing) <= 401


JUMPING_CLOCK = """
import itertools, time
_true, _calls = time.time_ns, itertools.count()
def _jumping():
    "An hour back and forth at every look."
    return _true() + (3_600_000_000_000 if next(_calls) % 2 else -3_600_000_000_000)
time.time_ns = _jumping
time.time = lambda: _jumping() / 1e9
"""


def test_a_wall_clock_that_jumps_moves_neither_control_nor_the_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "sitecustomize.py").write_text(JUMPING_CLOCK)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")]))
    with rig(tmp_path) as one:
        controller, _ = one.controller(), one.start("simulate")
        with one.session() as session:
            one.arm(session)
            start = one.status(session)
            end = one.until(session, lambda s: s.tick > start.tick + 100)
            assert end.mode is Mode.TRACKING
            assert end.stamp_ns > start.stamp_ns
        assert one.end(controller)[0] == 0
    entries = read_records(tmp_path / "run.mcap", {"cycle"})
    times = [entry.log_time for entry in entries if isinstance(entry, Message)]
    assert len(times) > 100
    steps = [later - earlier for earlier, later in itertools.pairwise(times)]
    assert min(steps) > 0
    assert max(steps) < 60_000_000_000


def test_arm_waits_until_the_arm_tracks_and_says_why_where_it_does_not(tmp_path: Path) -> None:
    def waited(process: "subprocess.Popen[str]", status: int) -> str:
        out, said = process.communicate(timeout=60.0)
        assert process.returncode == status, said
        return out + said

    with rig(tmp_path, SLOW) as one:
        controller = one.controller()
        one.start("simulate")
        with one.session() as session:
            one.until(session, lambda s: s.tip is not None)
            found = waited(one.start("arm", "--wait"), 0)
            assert "pretension: armed by the operator" in found
            assert "tracking after" in found
            one.ask(session, ControlAction.STOP)
            one.until(session, lambda s: s.mode is Mode.IDLE)
            arming = one.start("arm", "--wait")
            one.until(session, lambda s: s.mode is Mode.PRETENSION)
            one.ask(session, ControlAction.STOP)
            found = waited(arming, 1)  # releasing, or idle already
            assert "tendond: the arm does not track: " in found
            assert "asked to stop" in found
            one.until(session, lambda s: s.mode is Mode.IDLE)
            arming = one.start("arm", "--wait")
            one.until(session, lambda s: s.mode is Mode.PRETENSION)
            assert arming.stdout is not None
            assert "armed" in arming.stdout.readline() + arming.stdout.readline()  # it waits
            arming.send_signal(signal.SIGINT)
            found = waited(arming, 130)
            assert "tendond: no longer waiting: the controller goes on by itself (pretension, then tracking); " in found
            assert f"'tendond stop --config {one.config}' releases the tendons" in found
            one.until(session, lambda s: s.mode is Mode.TRACKING)
            found = waited(one.start("stop", "--wait"), 0)
            assert one.status(session).mode is Mode.IDLE
            assert "the tendons are released" in found.splitlines()[-1]
            assert "nothing to stop: the rig is idle" in waited(one.start("stop", "--wait"), 0)
        assert one.end(controller)[0] == 0
