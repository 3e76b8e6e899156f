"""Faults of the process and its surroundings: stopped, killed, full disk, hung and rival peers, requests."""

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import zenoh

from tendond.offline.logs.info import info
from tendond.offline.logs.log import load
from tendond.schemas.config.control import LoopSection
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.keys import ALIVE, key
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction, ControlRequest
from tests.sil.bench import ControllerBench
from tests.sil.rig import PATIENCE_SECONDS

pytestmark = pytest.mark.sil


def test_a_standstill_of_a_second_and_more_is_a_fault_and_a_moment_is_not(bench: ControllerBench) -> None:
    bench.track()
    missed = bench.status().loop.missed_ticks
    for seconds in (0.05, 1.5):
        assert bench.status().mode is Mode.TRACKING
        os.kill(bench.process.pid, signal.SIGSTOP)
        time.sleep(seconds)
        os.kill(bench.process.pid, signal.SIGCONT)
        missed = bench.missed_since(missed, 3)
    assert bench.fault().startswith("overrun: ")


def test_loop_and_recorder_alone_have_real_time_priority_and_the_loop_goes_first(bench: ControllerBench) -> None:
    """A recorder that is preempted while it holds the interpreter would hold up the loop."""
    tasks = [int(path.name) for path in Path(f"/proc/{bench.process.pid}/task").iterdir()]
    policies = [os.sched_getscheduler(task) & ~os.SCHED_RESET_ON_FORK for task in tasks]
    priorities = [
        os.sched_getparam(task).sched_priority
        for task, policy in zip(tasks, policies, strict=True)
        if policy == os.SCHED_FIFO
    ]
    if not priorities:
        pytest.skip("no real-time priority is permitted here")
    assert sorted(priorities) == [1, LoopSection().priority]


def test_a_hung_subscriber_does_not_hold_up_the_loop(bench: ControllerBench) -> None:
    bench.track()
    code = (
        "import sys, time, zenoh\nfrom tendond.bus.client import open_client\n"
        "with open_client(sys.argv[1], 60.0) as session:\n"
        "    all = session.declare_subscriber('**', zenoh.handlers.FifoChannel(1))\n"
        "    print(all.recv().key_expr, flush=True)\n    time.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code, bench.rig.endpoint], stdout=subprocess.PIPE, text=True) as hung:
        try:
            assert hung.stdout is not None
            assert hung.stdout.readline()
            os.kill(hung.pid, signal.SIGSTOP)
            start, heard = bench.status(), len(bench.peer.heard)
            after = bench.rig.until(bench.session, lambda s: s.tick > start.tick + 150)
            assert after.mode is Mode.TRACKING
            assert len(bench.peer.heard) > heard + 50
        finally:
            hung.kill()


def test_a_second_controller_is_refused_in_one_line_and_the_first_tracks_on(bench: ControllerBench) -> None:
    bench.track()
    second = bench.rig.start("run", "--log", str(bench.rig.folder / "second.mcap"))
    _, said = second.communicate(timeout=PATIENCE_SECONDS)
    assert second.returncode == 1
    assert "another controller" in said
    assert len([line for line in said.splitlines() if "compiling" not in line]) == 1
    assert bench.status().mode is Mode.TRACKING


def test_requests_that_cannot_be_read_or_do_not_fit_have_the_reason_as_reply(bench: ControllerBench) -> None:
    for name, payload, reason in (
        ("arm", b"", "the request is malformed"),
        ("arm", b'{"version":1,"action":"stop"}', "the request does not fit its key"),
        ("law", b'{"version":1,"action":"law"}', "the request is malformed"),
    ):
        (reply,) = bench.session.get(key(bench.rig.name, f"control/{name}"), payload=payload, timeout=60.0)
        assert reply.ok is not None
        assert reason in reply.ok.payload.to_string()


def test_law_and_reference_are_set_while_idle_and_refused_with_the_reason(bench: ControllerBench) -> None:
    bench.track()
    assert "stop first" in bench.ask(ControlRequest(action=ControlAction.LAW, law="sliding_mode"))
    assert bench.ask(ControlAction.STOP).startswith("stopped")
    bench.rig.until(bench.session, lambda s: s.mode is Mode.IDLE)
    assert "no law is called" in bench.ask(ControlRequest(action=ControlAction.LAW, law="pid"))
    said = bench.rig.command("rig", "law", "sliding_mode")
    assert (said.returncode, said.stdout) == (0, "law: sliding_mode\n")
    refused = bench.rig.command("rig", "reference", "across=0.8")
    assert refused.returncode == 1
    assert "the nearest is" in refused.stderr
    wrong = bench.rig.command("rig", "reference", "acros=0.2")
    assert wrong.returncode == 2
    assert "did you mean 'across'?" in wrong.stderr
    accepted = bench.rig.command("rig", "reference", "across=0.25", "kind=minimum_jerk")
    assert accepted.returncode == 0, accepted.stderr
    status = bench.status()
    assert (status.law, round(status.target[0], 6)) == ("sliding_mode", 0.25)
    reference = ReferenceSection(across=0.34)
    assert bench.ask(ControlRequest(action=ControlAction.REFERENCE, reference=reference)).startswith("reference: ")


def test_killed_it_loses_at_most_a_second_and_starts_disarmed_while_clients_come_back(bench: ControllerBench) -> None:
    """The hub's restart: the peer's session and the operator's find the new controller by themselves."""
    tokens = bench.session.liveliness().declare_subscriber(
        key(bench.rig.name, ALIVE), zenoh.handlers.FifoChannel(10), history=True
    )
    assert tokens.recv().kind == zenoh.SampleKind.PUT
    bench.track()
    bench.ask(ControlAction.STOP)
    bench.rig.until(bench.session, lambda s: s.mode is Mode.IDLE)
    assert bench.ask(ControlRequest(action=ControlAction.LAW, law="sliding_mode")).startswith("law: ")
    bench.track()
    bench.rig.until(bench.session, lambda s: len(bench.peer.heard) > 0)
    bench.process.kill()
    bench.process.communicate()
    last, first_log = bench.peer.heard[-1].seq, bench.log
    bench.log = bench.rig.folder / "again.mcap"
    bench.process = bench.rig.start("run", "--log", str(bench.log))
    assert tokens.recv().kind == zenoh.SampleKind.DELETE
    records = load(first_log).records
    assert info(first_log)["missing_ticks"] == 0
    assert records[-1].tick >= last - 100
    requests = [record.inputs.law for record in records if record.inputs.law and record.accepted]
    assert requests[-1] == "sliding_mode"
    bench.peer.heal()
    status = bench.rig.until(bench.session, lambda s: s.tip is not None)
    assert status.mode is Mode.IDLE
    assert tokens.recv().kind == zenoh.SampleKind.PUT


def test_a_full_disk_ends_the_log_and_not_the_control(bench: ControllerBench) -> None:
    bench.track()
    log = bench.log
    resource.prlimit(bench.process.pid, resource.RLIMIT_FSIZE, (log.stat().st_size + 20_000,) * 2)
    status = bench.rig.until(bench.session, lambda s: s.loop.log_error != "")
    assert "File too large" in status.loop.log_error
    assert status.mode is Mode.TRACKING
    bench.rig.until(bench.session, lambda s: s.tick > status.tick + 50 and s.mode is Mode.TRACKING)
    code, said = bench.rig.end(bench.process)
    assert code == 1
    assert "the log is incomplete" in said
    assert "Traceback" not in said
    assert not bench.peer.heard[-1].armed
    assert load(log).records
