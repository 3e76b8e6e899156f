"""Requests: a stop is always heard, what failed for its sender is not carried out later, planning holds up nothing."""

import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.offline.logs.log import load
from tendond.offline.replay.rerun import rerun
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.keys import control_key
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import decode, encode
from tests.sil.bus.live import Live
from tests.sil.rig import PATIENCE_SECONDS, Rig, flooded, rig

pytestmark = pytest.mark.sil

SPACE = '[control]\nlaw = "sensitivity"\n[reference]\nkind = "circle"\nradius = 0.1\nlaps = 1\n'


def test_a_stop_is_heard_under_a_flood_of_a_thousand_questions_a_second(live: Live) -> None:
    one = live.rig
    with one.session() as viewer, flooded(one, viewer) as put:
        heard = 0
        for _ in range(15):
            asked = time.monotonic()
            heard += ask(live.session, one.name, ControlAction.STOP).done
            assert time.monotonic() - asked < 1.0
            time.sleep(0.1)
        assert heard == 15
        assert put[0] > 500
    assert live.controller.poll() is None


def raw(session: zenoh.Session, one: Rig, request: ControlRequest, patience: float) -> ControlReply | None:
    """Send a request as a client of others may, without a deadline."""
    for reply in session.get(control_key(one.name, request.action.value), payload=encode(request), timeout=patience):
        if reply.ok is not None:
            return decode(ControlReply, reply.ok.payload.to_bytes())
    return None


@pytest.mark.parametrize("deadline", [True, False])
def test_a_request_that_has_failed_for_its_sender_is_never_carried_out(live: Live, deadline: bool) -> None:
    one, session = live.rig, live.session
    status = one.status(session)
    start, missed = status.tick, status.loop.missed_ticks
    live.controller.send_signal(signal.SIGSTOP)
    request = ControlRequest(action=ControlAction.ARM)
    if deadline:
        request = request.model_copy(
            update={"controller": status.source, "deadline_ns": time.monotonic_ns() + 500_000_000}
        )
    assert raw(session, one, request, 1.0) is None
    live.controller.send_signal(signal.SIGCONT)
    ticks = one.until(session, lambda status: status.loop.missed_ticks > missed).tick
    status = one.until(session, lambda status: status.tick > ticks + 50)
    assert status.mode is Mode.IDLE
    assert one.ask(session, ControlAction.ARM).done
    requests = [record.inputs.request for record in live.records(start)]
    assert requests.count(ControlAction.ARM) == 1


def test_a_request_to_a_controller_that_has_been_restarted_is_refused(live: Live) -> None:
    request = ControlRequest(action=ControlAction.RESET, controller="controller-000000")
    reply = raw(live.session, live.rig, request, 5.0)
    assert reply is not None
    assert reply.message == "not done: it was meant for the controller 'controller-000000', which is gone"


def test_what_was_asked_before_the_loop_was_ready_is_refused(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        controller = one.controller()
        one.start("simulate")
        with open_client(one.endpoint, PATIENCE_SECONDS) as session:
            request = ControlRequest(action=ControlAction.ARM)
            # The bus is open before the kernels are loaded: this one waits.
            reply = raw(session, one, request, PATIENCE_SECONDS)
            one.until(session, lambda status: status.tip is not None)
            assert one.status(session).mode is Mode.IDLE
        assert reply is not None
        assert (reply.done, reply.message) == (False, "not done: the controller was still starting; ask again")
        one.end(controller)


def circle(laps: int) -> ControlRequest:
    return ControlRequest(
        action=ControlAction.REFERENCE, reference=ReferenceSection(kind="circle", radius=0.2, laps=laps)
    )


@pytest.fixture(scope="module")
def space(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    """Yield a rig whose law moves the tip in space; the last of its tests ends it."""
    with rig(tmp_path_factory.mktemp("space"), SPACE) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            yield Live(one, session)


def test_a_reference_that_cannot_be_planned_is_refused_with_the_reason(space: Live) -> None:
    one, session = space.rig, space.session
    one.status(session)
    request = ControlRequest(
        action=ControlAction.REFERENCE,
        reference=ReferenceSection(kind="line", start=(0.1, 0.0, 0.45), end=(0.1, 0.1, 0.45)),
    )
    assert "more than reference.moved_max" in ask(session, one.name, request).message
    outcome = one.command("rig", "reference", "kind=line", "end=[0.1,0.1,0.45]")
    assert outcome.returncode == 2
    assert "start and end of a line must both have two numbers, or both three" in outcome.stderr
    assert space.controller.poll() is None


def test_a_reference_is_planned_beside_the_loop_and_replays_the_same(space: Live) -> None:
    one, session = space.rig, space.session
    with one.session() as other:
        one.until(session, lambda status: status.tip is not None)
        replies: list[ControlReply] = []

        def plan(laps: int) -> threading.Thread:
            thread = threading.Thread(target=lambda: replies.append(ask(other, one.name, circle(laps))))
            thread.start()
            return thread

        first = plan(40)
        time.sleep(0.3)
        before = one.status(session)
        refused = one.ask(session, ControlAction.ARM)
        assert refused.message == "not armed: a reference is being planned: wait for it, or stop to give it up"
        second = plan(2)
        first.join()
        assert replies[0].message == "not changed: another reference was asked for meanwhile"
        second.join()
        assert replies[1].done, replies[1].message
        assert replies[1].message.startswith("reference: circle, to ")
        third = plan(40)
        time.sleep(0.2)
        assert one.ask(session, ControlAction.STOP).done
        third.join()
        assert replies[2].message == "not changed: stopped while it was planned"
        after = one.status(session)
        passed = after.tick - before.tick
        assert passed > 50
        assert after.loop.missed_ticks - before.loop.missed_ticks <= max(5, passed // 20)
        one.arm(session)
        time.sleep(0.5)
    assert one.end(space.controller)[0] == 0
    assert rerun(one.folder / "run.mcap").first is None
    longest = max(timing.work_us for timing in load(one.folder / "run.mcap").timings)
    assert longest < 0.5e6, "a cycle that plans takes longer than that"


def test_a_missing_controller_is_reported_before_any_request(tmp_path: Path) -> None:
    with rig(tmp_path) as one, pytest.raises(BusError, match="no controller"), open_client(one.endpoint, 0.1):
        pass


def test_two_controllers_are_named_to_the_operator_and_a_stop_goes_to_both(live: Live) -> None:
    one, session = live.rig, live.session
    with one.session() as second:
        status = one.status(session)
        stopped = threading.Event()

        def also(query: zenoh.Query) -> None:
            own = status.model_copy(update={"source": "controller-second"})
            stopping = str(query.key_expr).endswith("stop")
            message = "stopped: releasing the tendons" if stopping else "tracking"
            query.reply(query.key_expr, encode(ControlReply(done=True, message=message, status=own)))
            query.drop()
            if stopping:
                stopped.set()

        queryables = [
            second.declare_queryable(control_key(one.name, name), also, complete=True) for name in ("status", "stop")
        ]
        deadline = time.monotonic() + PATIENCE_SECONDS
        while True:  # until the controller's side knows of the second one
            try:
                ask(session, one.name, ControlAction.RESET)  # changes nothing where it arrives
            except BusError as error:
                said = str(error)
                break
            assert time.monotonic() < deadline
        assert said == (
            f"2 controllers of rig 'sil' reply: '{status.source}' and 'controller-second'; stop all but one"
        ) or said.endswith(f"'controller-second' and '{status.source}'; stop all but one")
        reply = ask(session, one.name, ControlAction.STOP)
        assert stopped.wait(5.0)
        assert reply.done
        assert reply.message.startswith("2 controllers reply: ")
        assert "nothing to stop: idle" in reply.message
        assert "stopped: releasing the tendons" in reply.message
        for queryable in queryables:
            queryable.undeclare()
