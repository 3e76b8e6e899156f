"""Punctuality of the controller's loop against a bare loop, in one run on one machine: `tendond bench loop`."""

import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.daemon.control.cycle import step
from tendond.daemon.control.phases.modes import ACTIVE
from tendond.daemon.control.state import CycleSetup, initial_state
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.offline.bench.bare import Quantiles
from tendond.offline.logs.log import load
from tendond.offline.processes import END_SECONDS, START_SECONDS, free_port
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import TENDON_COMMAND, TIP_POSE, key
from tendond.schemas.messages import ControlAction, Mode, TipPose
from tendond.schemas.record import LoopTiming
from tendond.schemas.wire import encode

RIG = "bench"
ROUND_TRIPS = 300
LOCKSTEP_PAUSE = 0.5e-3
"""Pause between a command and the next pose [s]; about the time of a simulated step."""

TURN = 20
"""Round trips with the one before it is the other's turn."""

WARM_UP = 20
"""Round trips that are not counted."""

ANSWER_SECONDS = 1.0


@dataclass(frozen=True)
class PunctualityRow:
    """One thing measured [us], and its bare counterpart, if there is one."""

    name: str
    controller: Quantiles
    bare: Quantiles | None = None
    note: str = ""


def measure(seconds: float, progress: Callable[[str], None]) -> list[PunctualityRow]:
    """Time the controller's loop, and a bare loop and an echo in turn with it.

    Args:
        seconds: length of each run.
        progress: called with the name of what is being measured.

    Raises:
        TendondError: a process could not be started.
    """
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for label, extra, period in (
            ("100 Hz, euler, 200 nodes", PAPER, 0.01),
            ("250 Hz, default scheme", "[loop]\nperiod = 0.004\n[simulator]\nperiod = 0.004\n", 0.004),
        ):
            progress(label)
            rows += _punctuality(folder, label, extra, period, seconds)
        progress("pose to command")
        rows.append(_latency(folder, "pose to command at once (lockstep)", 0.0))
        rows.append(_latency(folder, "pose to command at 100 Hz, wait for the tick in it", 0.01))
        progress("recorder")
        rows.append(PunctualityRow("recorder's share of a cycle", _recorder(folder)))
    return rows


@contextmanager
def _process(*arguments: str) -> "Iterator[subprocess.Popen[str]]":
    """Run a process for the length of a block."""
    process = subprocess.Popen(
        [sys.executable, "-m", *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            process.send_signal(signal.SIGCONT)
        try:
            process.communicate(timeout=END_SECONDS)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()


def _bare(seconds: float, period: float) -> tuple[list[float], int]:
    with _process("tendond.offline.bench.bare", "bare", str(seconds), str(period)) as process:
        output, _ = process.communicate(timeout=seconds + START_SECONDS)
    try:
        result = json.loads(output)
    except ValueError as error:
        raise DaemonError("the bare loop gave no result") from error
    return result["late_us"], result["missed"]


def _punctuality(folder: Path, label: str, extra: str, period: float, seconds: float) -> list[PunctualityRow]:
    """Wake-up lateness and work of the tracking controller, between two halves of the bare loop."""
    before, missed_before = _bare(seconds / 2.0, period)
    config, log, endpoint = _configure(folder, f"run-{period}", extra)
    with (
        _process("tendond.cli", "run", "--config", str(config), "--log", str(log)),
        _process("tendond.cli", "simulate", "--config", str(config)),
        open_client(endpoint, START_SECONDS) as session,
    ):
        _arm(session)
        time.sleep(seconds)
    after, missed_after = _bare(seconds / 2.0, period)
    data = load(log)
    tracked = {record.tick for record in data.records if record.mode is Mode.TRACKING}
    timings = [timing for timing in data.timings if timing.tick in tracked]
    if not timings:
        raise DaemonError(f"{label}: the controller did not track; a run by hand with 'tendond demo' tells why")
    missed = sum(timing.missed_ticks for timing in timings)
    note = f"{missed} of {len(timings)} missed, bare {missed_before + missed_after} of {len(before) + len(after)}"
    rows = [
        PunctualityRow(
            f"{label}: wake-up after deadline",
            Quantiles.of([t.lateness_us for t in timings]),
            Quantiles.of(before + after),
            note,
        ),
        PunctualityRow(
            f"{label}: work of a cycle, wake-up to command",
            Quantiles.of([t.work_us for t in timings]),
            note=f"{sum(t.ahead for t in timings)} of {len(timings)} worked out before the deadline",
        ),
    ]
    for what, times in (
        ("of those not worked out before", [t.work_us for t in timings if not t.ahead]),
        ("working one out before the deadline, caches cold", [t.speculation_us for t in timings if t.speculation_us]),
    ):
        if times:
            rows.append(PunctualityRow(f"{label}: {what}", Quantiles.of(times)))
    return rows


def _configure(folder: Path, name: str, extra: str) -> tuple[Path, Path, str]:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config = folder / f"{name}.toml"
    config.write_text(f'{extra}\n[rig]\nname = "{RIG}"\n[bus]\nendpoint = "{endpoint}"\n', encoding="utf-8")
    return config, folder / f"{name}.mcap", endpoint


def _arm(session: zenoh.Session) -> None:
    deadline = time.monotonic() + START_SECONDS
    while True:
        try:
            reply = ask(session, RIG, ControlAction.ARM)
            if reply.done or (reply.status is not None and reply.status.mode in ACTIVE):  # a reply may come too late
                return
            said = reply.message
        except BusError as error:
            said = str(error)
        if time.monotonic() > deadline:
            raise DaemonError(f"the controller could not be armed: {said}")
        time.sleep(0.05)


def _latency(folder: Path, name: str, period: float) -> PunctualityRow:
    """Measure the time from a pose handed to Zenoh to the command for it, and the same for an echo, in turn."""
    config, log, endpoint = _configure(folder, f"latency-{period}", PAPER)
    bare_endpoint = f"tcp/127.0.0.1:{free_port()}"
    mode = [] if period else ["--lockstep"]
    with (
        _process("tendond.cli", "run", "--config", str(config), "--log", str(log), *mode) as controller_process,
        _process("tendond.offline.bench.bare", "echo", bare_endpoint, str(period)) as bare_process,
        open_client(endpoint, START_SECONDS) as session,
        open_client(bare_endpoint, START_SECONDS) as bare_session,
    ):
        controller = _RoundTrips(session, key(RIG, TIP_POSE), key(RIG, TENDON_COMMAND), "pose_seq")
        bare = _RoundTrips(bare_session, "bare/pose", "bare/command", "seq")
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

    def __init__(self, session: zenoh.Session, pose_key: str, command_key: str, field: str) -> None:
        self._commands = session.declare_subscriber(command_key, zenoh.handlers.FifoChannel(1000))
        self._poses = session.declare_publisher(pose_key, express=True)
        self._field = field
        self._seq = 0
        self.times: list[float] = []

    def go(self) -> None:
        """Measure one round trip; a missing command yields no time."""
        self._seq += 1
        y = 1e-6 * (self._seq % 2)
        pose = TipPose(seq=self._seq, stamp_ns=0, position=(0.0, y, 0.49), orientation=(1.0, 0.0, 0.0, 0.0))
        payload = encode(pose)
        started = time.monotonic()
        self._poses.put(payload)
        while time.monotonic() < started + ANSWER_SECONDS:
            sample = self._commands.try_recv()
            if sample is None:
                time.sleep(20e-6)
            elif json.loads(sample.payload.to_bytes()).get(self._field) == self._seq:
                self.times.append((time.monotonic() - started) * 1e6)
                return


def _recorder(folder: Path) -> Quantiles:
    """Time handing a cycle to the recorder, a hundred times a second, right after the cycle."""
    config = RigConfig()
    setup = CycleSetup.from_config(config)
    inputs = [record.inputs for record in closed_loop(config, 500, {5: ControlAction.ARM})]
    state, times = initial_state(setup), []
    with RunLog(folder / "recorder.mcap", config, setup.rod) as run_log:
        for tick, arrived in enumerate(inputs):
            state, _, record = step(setup, state, arrived)
            timing = LoopTiming(tick=tick, lateness_us=1.0, work_us=1.0, missed_ticks=0)
            started = time.monotonic()
            run_log.cycle(record, timing, state.rod, None)
            times.append((time.monotonic() - started) * 1e6)
            time.sleep(config.loop.period)
    return Quantiles.of(times)
