"""The rig live: a thread that takes the bus's messages, draws the model's rod, and makes frames of both."""

import json
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress

import zenoh

from tendond.cli.dashboard.frame import frame
from tendond.cli.dashboard.ghost import Ghost
from tendond.cli.rig.tuning import tunable_rows
from tendond.cli.rig.watch import Listener
from tendond.daemon.recording.channels import ROD_SHAPE
from tendond.model.rods.selection import model_rod
from tendond.offline.viewer.relay import KINDS, QUEUE, LiveScene
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import control_key
from tendond.schemas.messages import ACTIVE, ENCODING, Message, Status
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode

FRAME_SECONDS = 0.05
POLL_SECONDS = 0.2
"""Time between two questions for the status while the arm is held: the target moves, and is published each second."""

SLOW_SECONDS = 1.0
"""Time between two looks at the tunable keys; each frame has the list, since a slow page gets few of the frames."""

TOPICS = {topic: (kind, QUEUE) for topic, kind in KINDS.items()}


class NewestShape:
    """Sink for the scene that keeps the newest shape of the rod, as JSON."""

    def __init__(self) -> None:
        self.shape = "null"

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """Take a message."""
        if topic == ROD_SHAPE.topic:
            self.shape = data.decode()


class StatusPoll:
    """Questions for the status whose replies come by themselves: nobody waits for a controller that hangs."""

    def __init__(self, rig: str) -> None:
        self._key, self._asked = control_key(rig, ControlAction.STATUS.value), 0.0
        self._payload = encode(ControlRequest(action=ControlAction.STATUS))
        self._found: deque[Status] = deque(maxlen=1)

    def ask(self, session: zenoh.Session, now: float) -> None:
        """Ask, if it is time for it; `now` on the monotonic clock [s]."""
        if now - self._asked >= POLL_SECONDS:
            self._asked = now
            session.get(self._key, self._reply, payload=self._payload, encoding=ENCODING, timeout=1.0)

    def newest(self) -> Status | None:
        """Take the newest status that has come."""
        return self._found.pop() if self._found else None

    def _reply(self, reply: zenoh.Reply) -> None:
        """Keep a status, on Zenoh's thread."""
        with suppress(UnreadableError):
            if reply.ok is not None and (status := decode(ControlReply, reply.ok.payload.to_bytes()).status):
                self._found.append(status)


class Live:
    """Frames of a rig, each `FRAME_SECONDS`.

    Args:
        config: of the rig.
        option: that names the rig, in commands.
        send: takes each frame as JSON, on the thread of `run`.
        returned: called when a controller is heard again, or another one.
    """

    def __init__(
        self, config: RigConfig, option: str, send: Callable[[str], None], returned: Callable[[], None]
    ) -> None:
        self._config, self._option, self._send, self._returned = config, option, send, returned
        self._sink = NewestShape()
        self._scene = LiveScene(config, self._sink)
        self._ghost = Ghost(model_rod(config), config)
        self._ghost_of: tuple[Vector3, object] | None = None
        self._poll = StatusPoll(config.rig.name)
        self._listener = Listener(config, TOPICS, self._receive)
        self._source, self._slow = "", 0.0
        self._keys: object = None

    def run(self, ended: threading.Event) -> None:
        """Make frames until `ended` is set."""
        while not ended.is_set():
            began = time.monotonic()
            self._listener.listen()
            self._take_status()
            self._send(self._frame())
            ended.wait(max(0.0, began + FRAME_SECONDS - time.monotonic()))
        self._listener.close()

    def _receive(self, message: Message) -> None:
        self._scene.add(message, time.time_ns())

    def _take_status(self) -> None:
        """Ask for the status while the arm is held, and take what came."""
        snapshot, session, now = self._listener.snapshot, self._listener.session, time.monotonic()
        if session is None or snapshot.is_silent(now):
            return
        before = snapshot.status
        if before is not None and before.mode in ACTIVE:
            with suppress(zenoh.ZError):  # the session closes with its controller; the listener opens another
                self._poll.ask(session, now)
        came = self._poll.newest()
        if came and before and came.source == before.source and came.stamp_ns > before.stamp_ns:
            snapshot.add(came, now)
            self._receive(came)

    def _frame(self) -> str:
        now, snapshot = time.monotonic(), self._listener.snapshot
        shown = frame(snapshot, self._config, now, self._option)
        status = snapshot.status
        if status is None or shown["silent"]:
            self._source = ""
        elif status.source != self._source:
            self._source = status.source
            self._returned()
        if status is not None and not shown["silent"]:
            self._scene.draw(time.time_ns())
            shown["ghost"] = self._ghost_at(status.target)
            shown["tunable"] = self._tunable(status, now)
        text = json.dumps(shown, allow_nan=False)
        return f'{text[:-1]}, "scene": {self._sink.shape}}}'

    def _ghost_at(self, target: Vector3) -> object:
        if self._ghost_of is None or self._ghost_of[0] != target:
            self._ghost_of = (target, self._ghost.shape(target))
        return self._ghost_of[1]

    def _tunable(self, status: Status, now: float) -> object:
        if self._keys is None or now - self._slow >= SLOW_SECONDS:
            self._slow, self._keys = now, tunable_rows(self._config, status)
        return self._keys
