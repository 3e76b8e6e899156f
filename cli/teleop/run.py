"""Stream the hand's wishes to the controller, which bounds them, and holds the place when they end."""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask, ask_status
from tendond.bus.query import replies
from tendond.bus.subscription import Subscription
from tendond.cli.common import load_config, say
from tendond.cli.rig.operator import option_of, remedy
from tendond.cli.rig.teach import CONNECT_SECONDS, KEPT, write
from tendond.cli.teleop.gamepad import Gamepad, found_gamepad
from tendond.cli.teleop.hand import Hand, Wish
from tendond.cli.teleop.keyboard import Keyboard
from tendond.daemon.errors import DaemonError, UsageError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.teleop import SPEED
from tendond.schemas.keys import TIP_POSE, control_key, key
from tendond.schemas.messages import Mode, Status, TipPose
from tendond.schemas.remedies import sentence
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import encode

PERIOD = 0.05
"""Time between two requests while the hand moves the target [s]: six within the default `teleop.timeout`."""

REST_PERIOD = 0.5
"""The same while it does not: a fault is noticed by then [s]."""

REPLY_SECONDS, FRESH_SECONDS = 0.5, 0.15
"""Time to wait for a reply, and age from which on the controller no longer carries a request out [s]."""

REFUSALS = 5
"""Requests in a row that may be refused for having come too late."""

SMOOTHING = 0.1
"""Standard deviation of the recorded path's filter, as of `teach record` [s]."""


class Stream:
    """The requests to one controller.

    Args:
        session: open. rig: its name. status: of its controller, just received.
    """

    def __init__(self, session: zenoh.Session, rig: str, status: Status) -> None:
        self._session, self._rig, self._source = session, rig, status.source
        self._behind_ns = status.stamp_ns - time.monotonic_ns()  # written before it came: deadlines are never late
        self._refused = 0

    def send(self, speed: float) -> ControlReply:
        """Ask for a speed [m/s], and return the reply.

        Raises:
            BusError: there is none.
        """
        wanted = ControlRequest(
            action=ControlAction.JOG,
            jog=speed,
            controller=self._source,
            deadline_ns=max(0, time.monotonic_ns() + self._behind_ns + round(FRESH_SECONDS * 1e9)),
        )
        expression = control_key(self._rig, ControlAction.JOG.value)
        found = replies(self._session, expression, encode(wanted), REPLY_SECONDS, "controller")
        if not found:
            raise BusError(f"the controller of rig '{self._rig}' no longer replies: the target holds its place")
        late = not found[0].done and found[0].status is None  # refused before it came into a cycle
        self._refused = self._refused + 1 if late else 0
        return found[0]

    @property
    def fails(self) -> bool:
        """True if the last requests were all refused for having come too late."""
        return self._refused >= REFUSALS


def run_teleop(
    config_file: Path | None, *, gamepad: str | None, part: float, record: Path | None, stopped: Callable[[], bool]
) -> None:
    """Move the target by hand until that ends; see `tendond teleop --help`.

    Args:
        config_file: the rig's configuration file.
        gamepad: event device, "auto" for the first one; none: keys.
        part: of `teleop.speed_max` that a full stick, or a key at full speed, asks for.
        record: CSV file to which the measured path is written as a reference.
        stopped: true when the process is to end.

    Raises:
        TendondError: no controller, it refused, or the input is lost.
    """
    config = load_config(config_file)
    hand: Hand = Keyboard() if gamepad is None else Gamepad(found_gamepad() if gamepad == "auto" else Path(gamepad))
    poses: list[tuple[float, TipPose]] = []
    with hand, open_client(config.bus.endpoint, CONNECT_SECONDS) as session:
        status = ask_status(session, config.rig.name)
        if status.mode is not Mode.TRACKING:
            text = f"not moved: {status.mode.value}"
            advice = remedy(status, config, config_file) or f"'tendond arm --wait{option_of(config_file)}' first"
            raise UsageError(f"{sentence(text, status.mode, '', option_of(config_file))}: {advice}")
        subscription = None
        if record is not None:
            subscription = Subscription(session, key(config.rig.name, TIP_POSE), TipPose, KEPT)

        def take_poses() -> None:
            for pose in subscription or ():
                poses.append((pose.stamp_ns * 1e-9, pose))

        stream = Stream(session, config.rig.name, status)
        say(hand.help)
        end = _follow(hand, stream, part * speed_max(config), stopped, take_poses)
        if sys.stdout.isatty():
            print()
        if end == "stop":
            print(ask(session, config.rig.name, ControlAction.STOP).message)
        else:
            stream.send(0.0)
            print("the target holds its place")
    if record is not None:
        write(config, poses, record, None, SMOOTHING, option_of(config_file))
    if end == "lost":
        raise DaemonError("the input is lost: is the gamepad unplugged, or the terminal closed?")


def speed_max(config: RigConfig) -> float:
    """Return the largest speed of a configuration's target [m/s]; the controller bounds it by its own."""
    given = config.teleop.speed_max
    return SPEED * config.rod.backbone_length if given is None else given


def _follow(
    hand: Hand, stream: Stream, speed: float, stopped: Callable[[], bool], take_poses: Callable[[], None]
) -> str:
    """Send what the hand says until it ends; return how.

    Raises:
        DaemonError: the controller refused. BusError: it is gone.
    """
    before, next_rest, shown = 0.0, 0.0, ""
    while not stopped():
        wish: Wish = hand.wait(PERIOD)
        take_poses()
        if wish.end:
            return wish.end
        now = time.monotonic()
        if wish.part == 0.0 and before == 0.0 and now < next_rest:
            continue
        reply = stream.send(wish.part * speed)
        before, next_rest = wish.part, now + REST_PERIOD
        if stream.fails or (not reply.done and reply.status is not None):
            raise DaemonError(reply.message)
        if (text := _in_words(reply, wish.part * speed)) != shown:
            _show(text)
            shown = text
    return "hold"


def _in_words(reply: ControlReply, speed: float) -> str:
    return f"{reply.message} at {speed:+.3f} m/s" if reply.message == "moving" else reply.message


def _show(text: str) -> None:
    """Print a line; on a terminal in the place of the last one."""
    if sys.stdout.isatty():
        print(f"\r\x1b[K{text}", end="", flush=True)
    else:
        print(text, flush=True)
