"""Punctuality of the controller's loop against a bare loop, in one run on one machine: `tendond bench loop`."""

import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.daemon.control.cycle import step
from tendond.daemon.control.phases.modes import ACTIVE
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.offline.bench.bare import Quantiles
from tendond.offline.bench.latency import latencies
from tendond.offline.bench.rigs import RIG, PunctualityRow, configure, process
from tendond.offline.logs.log import load
from tendond.offline.processes import START_SECONDS
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.record import LoopTiming
from tendond.schemas.requests import ControlAction


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
            ("100 Hz, euler, 200 nodes", f"{PAPER}\n[loop]\nphase_lock = false\n", 0.01),
            (
                "250 Hz, default scheme",
                "[loop]\nperiod = 0.004\nphase_lock = false\n[simulator]\nperiod = 0.004\n",
                0.004,
            ),
        ):
            progress(label)
            rows += _punctuality(folder, label, extra, period, seconds)
        progress("pose to command")
        rows += latencies(folder)
        progress("recorder")
        rows.append(PunctualityRow("recorder's share of a cycle", _recorder(folder)))
    return rows


def _bare(seconds: float, period: float) -> tuple[list[float], int]:
    with process("tendond.offline.bench.bare", "bare", str(seconds), str(period)) as bare:
        output, _ = bare.communicate(timeout=seconds + START_SECONDS)
    try:
        result = json.loads(output)
    except ValueError as error:
        raise DaemonError("the bare loop gave no result") from error
    return result["late_us"], result["missed"]


def _punctuality(folder: Path, label: str, extra: str, period: float, seconds: float) -> list[PunctualityRow]:
    """Wake-up lateness and work of the tracking controller, between two halves of the bare loop."""
    before, missed_before = _bare(seconds / 2.0, period)
    config, log, endpoint = configure(folder, f"run-{period}", extra)
    with (
        process("tendond.cli", "run", "--config", str(config), "--log", str(log)),
        process("tendond.cli", "simulate", "--config", str(config)),
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
