"""`tendond watch`: a rig live in the terminal, over Zenoh; a client that only listens."""

import time
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import Any

import zenoh
from rich.console import Console
from rich.live import Live

from tendond.bus.client import BusError, open_client
from tendond.bus.subscription import Subscription
from tendond.cli.common import load_config
from tendond.cli.rig.operator import option_of
from tendond.cli.watch.bus_snapshot import FRAMES_PER_SECOND, BusSnapshot
from tendond.cli.watch.plain import shown
from tendond.cli.watch.screen import frame, line
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import STATUS, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import Message, Status, TendonCommand, TendonState, TipPose

TOPICS: dict[str, tuple[type[Message], int]] = {
    STATUS: (Status, 1),
    TIP_POSE: (TipPose, 32),
    TENDON_COMMAND: (TendonCommand, 1),
    TENDON_STATE: (TendonState, 1),
}
"""Class of the messages, and how many are kept between two frames: every pose is part of the trail."""

FRAME_SECONDS = 1.0 / FRAMES_PER_SECOND
LINE_SECONDS = 1.0
ONCE_SECONDS, ONCE_SPAN = 3.0, 1.0
"""Longest time to wait for a single frame [s], and the time of poses that is enough to measure their rate [s]."""

AGAIN_SECONDS = 3.0
"""Time without a controller after which the session is reopened."""

DEFAULT_HEIGHT = 24


class Listener:
    """Receiver of a rig's messages, a frame at a time; reconnects by itself.

    Args:
        config: the rig's configuration.
        topics: to subscribe to, as `TOPICS`.
        receive: takes each message beside the snapshot.

    Attributes:
        snapshot: of all that was received.
        session: the open session; none without a controller.
    """

    def __init__(
        self,
        config: RigConfig,
        topics: Mapping[str, tuple[type[Message], int]] = TOPICS,
        receive: Callable[[Message], None] = lambda message: None,
    ) -> None:
        self.snapshot = BusSnapshot()
        self.session: zenoh.Session | None = None
        self._config, self._topics, self._receive = config, topics, receive
        self._subscriptions: list[Subscription[Any]] = []
        self._opened = 0.0

    def listen(self) -> None:
        """Take the messages since the last call; without a controller, try once to connect."""
        now = time.monotonic()
        if self.snapshot.is_silent(now) and now - self._opened > AGAIN_SECONDS:
            self.close()
        if self.session is None:
            try:
                self.session = open_client(self._config.bus.endpoint, 0.0)
            except BusError:
                return
            self._opened = time.monotonic()
            name = self._config.rig.name
            self._subscriptions = [
                Subscription(self.session, key(name, topic), kind, size) for topic, (kind, size) in self._topics.items()
            ]
        for subscription in self._subscriptions:
            for message in subscription:
                self.snapshot.add(message, time.monotonic())
                self._receive(message)
        self.snapshot.tick(time.monotonic())

    def close(self) -> None:
        """Close the session."""
        if self.session is not None:
            self.session.close()
            self.session = None


def run_watch(config_file: Path | None, *, once: bool) -> None:
    """Show the rig until a signal comes, or once; see `tendond watch --help`.

    Raises:
        ConfigError: the configuration cannot be used.
        BusError: one frame is wanted, and there is no controller.
    """
    config = load_config(config_file)
    console = Console(highlight=False)
    listener, option = Listener(config), option_of(config_file)
    try:
        if once:
            _once(listener, config, console, option)
        elif console.is_terminal and not console.is_dumb_terminal:
            _live(listener, config, console, option)
        else:
            _lines(listener, config, option)
    finally:
        listener.close()


def _live(listener: Listener, config: RigConfig, console: Console, option: str) -> None:
    """Draw frame after frame."""
    with Live(console=console, screen=True, auto_refresh=False, vertical_overflow="crop") as live:
        while True:
            began = time.monotonic()
            listener.listen()
            width, height = console.size
            image = frame(listener.snapshot, config, time.monotonic(), width, height, option)
            live.update(shown(image, console.encoding), refresh=True)
            time.sleep(max(0.0, began + FRAME_SECONDS - time.monotonic()))


def _lines(listener: Listener, config: RigConfig, option: str) -> None:
    """Print a line each second, and at once when the mode changes."""
    shown, due = "", 0.0
    while True:
        listener.listen()
        now = time.monotonic()
        status = listener.snapshot.status
        mode = "waiting" if status is None or listener.snapshot.is_silent(now) else status.mode.value
        if mode != shown or now >= due:
            print(f"{datetime.now().astimezone():%H:%M:%S} {line(listener.snapshot, config, now, option)}", flush=True)
            shown, due = mode, now + LINE_SECONDS
        time.sleep(FRAME_SECONDS)


def _once(listener: Listener, config: RigConfig, console: Console, option: str) -> None:
    """Print one frame, once every message has arrived, or after `ONCE_SECONDS`."""
    deadline = time.monotonic() + ONCE_SECONDS
    snapshot = listener.snapshot
    while time.monotonic() < deadline and not (
        snapshot.status and snapshot.command and snapshot.pose and snapshot.pose_stream.span >= ONCE_SPAN
    ):
        listener.listen()
        time.sleep(FRAME_SECONDS)
    now = time.monotonic()
    if snapshot.status is None or snapshot.is_silent(now):
        raise BusError(
            f"no controller of rig '{config.rig.name}' at {config.bus.endpoint}: start it with 'tendond run'"
        )
    image = frame(snapshot, config, now, console.width, DEFAULT_HEIGHT, option)
    console.print(shown(image, console.encoding))
