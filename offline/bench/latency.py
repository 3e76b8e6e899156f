"""Time from a pose to its command, measured by an outside process, against an echo: `tendond bench latency`."""

import random
import signal
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import zenoh

from tendond.bus.client import open_client
from tendond.bus.subscription import Subscription, listen
from tendond.daemon.errors import DaemonError
from tendond.offline.bench.bare import Quantiles
from tendond.offline.bench.rigs import RIG, PunctualityRow, configure, process
from tendond.offline.processes import START_SECONDS, free_port
from tendond.schemas.config.presets import PAPER
from tendond.schemas.keys import TENDON_COMMAND, TIP_POSE, key
from tendond.schemas.messages import Message, TendonCommand, TipPose
from tendond.schemas.wire import encode

ROUND_TRIPS = 300
LOCKSTEP_PAUSE = 0.5e-3
"""Pause between a command and the next pose [s]; about the time of a simulated step."""

TURN = 20
"""Round trips with the one before it is the other's turn."""

WARM_UP = 20
"""Round trips that are not counted."""

SETTLING = 250
"""Poses that are not counted where the loop has to find their phase."""

REPLY_SECONDS = 1.0

QUEUE = 1000
"""Replies that are kept between two looks: those of ten seconds."""

PERIOD = 0.01
"""Period of the loop and of the poses [s]."""

JITTER = 0.1e-3
"""Standard deviation of the time at which a pose is sent [s]: a camera's."""


@dataclass(frozen=True)
class Route:
    """Keys of a pose and of what replies to it.

    Attributes:
        pose, command: full keys. kind: class of the replies.
        pose_seq: number of the pose that a reply is for.
    """

    pose: str
    command: str
    kind: type[Message]
    pose_seq: Callable[[Any], int | None]


CONTROLLER = Route(key(RIG, TIP_POSE), key(RIG, TENDON_COMMAND), TendonCommand, lambda command: command.pose_seq)
ECHO = Route("bare/pose", "bare/command", TipPose, lambda pose: pose.seq)


def measure_latency(progress: Callable[[str], None]) -> list[PunctualityRow]:
    """Time poses to their commands; see `latencies`.

    Raises:
        TendondError: a process could not be started.
    """
    progress("pose to command")
    with tempfile.TemporaryDirectory() as name:
        return latencies(Path(name))


def latencies(folder: Path) -> list[PunctualityRow]:
    """Time poses to their commands: in lockstep, at any phase of a fixed-rate loop, and of a camera at its rate.

    Raises:
        TendondError: a process could not be started.
    """
    return [
        _random_phase(folder, "pose to command at once (lockstep)", 0.0),
        _random_phase(folder, "pose to command at 100 Hz, poses at any phase", PERIOD),
        _camera(folder, "pose to command at 100 Hz, camera at 100 Hz, phase locked", lock=True),
        _camera(folder, "pose to command at 100 Hz, camera at 100 Hz, phase free", lock=False),
    ]


def _camera(folder: Path, name: str, *, lock: bool) -> PunctualityRow:
    """Send poses at the loop's rate, from a phase of their own; the bare counterpart is an echo that waits for none."""
    config, log, endpoint = configure(folder, f"camera-{lock}", f"{PAPER}\n[loop]\nphase_lock = {str(lock).lower()}\n")
    bare_endpoint = f"tcp/127.0.0.1:{free_port()}"
    with (
        process("tendond.cli", "run", "--config", str(config), "--log", str(log)),
        open_client(endpoint, START_SECONDS) as session,
    ):
        times = _paced(session, CONTROLLER)
    with (
        process("tendond.offline.bench.bare", "echo", bare_endpoint, "0.0"),
        open_client(bare_endpoint, START_SECONDS) as bare_session,
    ):
        bare = _paced(bare_session, ECHO)
    return PunctualityRow(name, Quantiles.of(times), Quantiles.of(bare))


def _paced(session: zenoh.Session, route: Route) -> list[float]:
    """Times from poses that are sent at a camera's rate to the first command for each [us]."""
    replied: dict[int | None, float] = {}

    def reply(command: Message, arrived: float) -> None:
        replied.setdefault(route.pose_seq(command), arrived)

    sent: dict[int, float] = {}
    draw, give_up = random.Random(0), time.monotonic() + START_SECONDS
    poses = session.declare_publisher(route.pose, express=True)
    subscriber = listen(session, route.command, route.kind, reply)
    try:
        due = time.monotonic()
        while len(sent) < SETTLING + ROUND_TRIPS:
            due += PERIOD
            time.sleep(max(0.0, due + draw.gauss(0.0, JITTER) - time.monotonic()))
            payload = encode(_pose(len(sent)))
            now = time.monotonic()
            poses.put(payload)
            if replied or now < give_up - START_SECONDS + REPLY_SECONDS:
                sent[len(sent)] = now
            elif now > give_up:
                raise DaemonError("the controller, or the echo, did not reply")
        time.sleep(REPLY_SECONDS)
    finally:
        subscriber.undeclare()
    times = [(replied[seq] - at) * 1e6 for seq, at in sent.items() if seq >= SETTLING and seq in replied]
    if not times:
        raise DaemonError("the controller, or the echo, did not reply")
    return times


def _random_phase(folder: Path, name: str, period: float) -> PunctualityRow:
    """Measure the time from a pose handed to Zenoh to the command for it, and the same for an echo, in turn."""
    config, log, endpoint = configure(folder, f"latency-{period}", PAPER)
    bare_endpoint = f"tcp/127.0.0.1:{free_port()}"
    mode = [] if period else ["--lockstep"]
    with (
        process("tendond.cli", "run", "--config", str(config), "--log", str(log), *mode) as controller_process,
        process("tendond.offline.bench.bare", "echo", bare_endpoint, str(period)) as bare_process,
        open_client(endpoint, START_SECONDS) as session,
        open_client(bare_endpoint, START_SECONDS) as bare_session,
    ):
        controller = _RoundTrips(session, CONTROLLER)
        bare = _RoundTrips(bare_session, ECHO)
        deadline, draw = time.monotonic() + START_SECONDS, random.Random(0)
        while len(controller.times) < ROUND_TRIPS + WARM_UP:
            for one, resting in ((controller, bare_process), (bare, controller_process)):
                resting.send_signal(signal.SIGSTOP)  # what polls beside it would count as well
                for _ in range(TURN):
                    one.go()
                    time.sleep(LOCKSTEP_PAUSE if not period else 0.005 + draw.random() * period)  # any phase of it
                resting.send_signal(signal.SIGCONT)
            if time.monotonic() > deadline:
                raise DaemonError("the controller, or the echo, did not reply")
    return PunctualityRow(name, Quantiles.of(controller.times[WARM_UP:]), Quantiles.of(bare.times[WARM_UP:]))


class _RoundTrips:
    """Times [us] from poses on one key to their commands on another."""

    def __init__(self, session: zenoh.Session, route: Route) -> None:
        self._replies = Subscription(session, route.command, route.kind, QUEUE)
        self._poses = session.declare_publisher(route.pose, express=True)
        self._route = route
        self._seq = 0
        self.times: list[float] = []

    def go(self) -> None:
        """Measure one round trip; a missing command yields no time."""
        self._seq += 1
        payload = encode(_pose(self._seq))
        started = time.monotonic()
        self._poses.put(payload)
        while time.monotonic() < started + REPLY_SECONDS:
            if any(self._route.pose_seq(command) == self._seq for command in self._replies):
                self.times.append((time.monotonic() - started) * 1e6)
                return
            time.sleep(20e-6)


def _pose(seq: int) -> TipPose:
    """A resting tip; every other pose is another one, so that it does not look frozen."""
    return TipPose(
        seq=seq, stamp_ns=time.monotonic_ns(), position=(0.0, 1e-6 * (seq % 2), 0.49), orientation=(1.0, 0.0, 0.0, 0.0)
    )
