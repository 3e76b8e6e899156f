"""A real controller process with a scripted peer, and faults of what the peer sends."""

import time
from collections.abc import Callable
from typing import Any

import zenoh

from tendond.bus.operator import ask
from tendond.schemas.messages import Mode, Status, TipPose
from tendond.schemas.requests import ControlAction, ControlRequest
from tests.sil.peer import Outgoing, Peer
from tests.sil.rig import PATIENCE_SECONDS, Rig

QUICK = """
[limits]
release_rate = 1000.0
limit_time = 10.0
[reference]
kind = "minimum_jerk"
duration = 0.5
[faults]
pose_timeout = 1.0
tendon_timeout = 1.2
overrun_time = 0.9
"""
"""Short times, so that the tests are short, but thresholds of time wider than the defaults: the machine may stand still
for a while, the controller may not. Those of space are the defaults."""


class ControllerBench:
    """Rig, controller process, operator's session and peer."""

    def __init__(self, one: Rig, session: zenoh.Session, peer: Peer) -> None:
        self.rig, self.session, self.peer = one, session, peer
        self.process = one.processes[0]
        self.log = one.folder / "run.mcap"

    def track(self, alter: Callable[[TipPose], Outgoing] | None = None) -> None:
        """Bring the controller to tracking, from any mode; with `alter`, poses are altered from the arming on."""
        self.peer.heal()
        rounds = self.peer.rounds
        while self.peer.rounds < rounds + 3:  # what was bad before is followed by something good
            time.sleep(0.005)
        status = self.rig.until(self.session, lambda s: s.mode is Mode.TRACKING or s.tension == (0.0,) * 4)
        if status.mode is Mode.TRACKING and alter is None:
            return
        if status.mode is Mode.TRACKING:
            self.ask(ControlAction.STOP)
            self.rig.until(self.session, lambda s: s.mode is Mode.IDLE)
        deadline = time.monotonic() + PATIENCE_SECONDS
        while True:  # a rod that still swings from its release may be a fault again
            assert time.monotonic() < deadline, self.status()
            if self.status().mode is Mode.FAULT:
                self.rig.ask(self.session, ControlAction.RESET)
            if not self.rig.ask(self.session, ControlAction.ARM).done:
                time.sleep(0.02)
                continue
            if alter is not None:
                self.peer.alter = alter
                return
            ended = self.rig.until(self.session, lambda s: s.mode in (Mode.TRACKING, Mode.FAULT))
            if ended.mode is Mode.TRACKING:
                return

    def ask(self, request: ControlAction | ControlRequest) -> str:
        reply = ask(self.session, self.rig.name, request)
        return reply.message if reply.done else f"refused: {reply.message}"

    def fault(self) -> str:
        """Wait for a fault, then for slack tendons; return the reason."""
        status = self.rig.until(self.session, lambda s: s.mode is Mode.FAULT and s.tension == (0.0,) * 4)
        return status.reason

    def status(self) -> Status:
        return self.rig.status(self.session)

    def missed_since(self, before: int, more: int) -> int:
        """Wait until so many more ticks are missed; return their number."""
        status = self.rig.until(self.session, lambda s: s.loop.missed_ticks >= before + more)
        return status.loop.missed_ticks

    def await_rejected(self, reason: str, count: int) -> None:
        """Wait until so many messages are rejected for a reason."""
        self.rig.until(self.session, lambda s: s.rejected.get(reason, 0) >= count)

    def counted(self, reason: str) -> int:
        return self.status().rejected.get(reason, 0)


def once(left: list[bytes | None]) -> Callable[[TipPose], Outgoing]:
    """Return a change of poses: what is `left` comes before the next pose, then poses as they are."""

    def alter(pose: TipPose) -> Outgoing:
        yield from left
        left.clear()
        yield pose

    return alter


def changed_briefly(change: dict[str, Any]) -> Callable[[TipPose], Outgoing]:
    """Return a change of the next three poses, of which at least one reaches a cycle; then poses as they are."""
    done: list[bool] = []

    def alter(pose: TipPose) -> Outgoing:
        yield pose if len(done) >= 3 else pose.model_copy(update=change)
        done.append(True)

    return alter


def moved(pose: TipPose, position: tuple[float, float, float]) -> TipPose:
    return pose.model_copy(update={"position": position})


def frozen() -> Callable[[TipPose], Outgoing]:
    first: list[TipPose] = []

    def alter(pose: TipPose) -> Outgoing:
        first.append(pose)
        yield moved(pose, first[0].position)

    return alter
