"""Speed of replaying a log, and the cycle's share of it, measured in one run on a log written for it."""

import gc
import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from tendond.daemon.control.cycle import step
from tendond.daemon.control.state import initial_state
from tendond.offline.logs.run import open_run
from tendond.offline.replay.offline import record_lockstep
from tendond.offline.replay.rerun import inputs_of, recorded_setup, rerun
from tendond.offline.replay.segments import Gaps, segments
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import parse_config
from tendond.schemas.requests import ControlAction

ARMED_AT = 10
ROUNDS = 3
"""Repetitions, of which the best counts: the machine may have other things to do."""


@dataclass(frozen=True)
class ReplayRow:
    """name: of what was timed; cycle_us: per cycle [us]; speed: times real time."""

    name: str
    cycle_us: float
    speed: float


def bench_replay(seconds: float, watch: Callable[[str], None] = lambda name: None) -> list[ReplayRow]:
    """Time `step` alone on the inputs of a log, then replays of that log.

    Args:
        seconds: length of the log: the paper's experiment, Euler's scheme with 200 nodes.
        watch: called with what is being done.
    """
    with TemporaryDirectory() as folder:
        path = Path(folder) / "bench.mcap"
        watch("recording a log")
        config = parse_config(PAPER, "bench")
        setup = recorded_setup(config, "bench")
        cycles = round(seconds / config.loop.period)
        record_lockstep(setup, cycles, {ARMED_AT: ControlAction.ARM}, path)
        inputs = [inputs_of(data) for segment in segments(open_run(path), Gaps()) for data in segment.cycles]

        def steps() -> float:
            state = initial_state(setup)
            gc.collect()
            started = time.perf_counter()
            for one in inputs:
                state, _, _ = step(setup, state, one)
            return time.perf_counter() - started

        def replay(jobs: int) -> float:
            outcome = rerun(path, jobs=jobs)
            assert outcome.first is None
            return outcome.seconds

        timed: dict[str, Callable[[], float]] = {
            "the cycle's step alone": steps,
            "replay, 1 process": lambda: replay(1),
        }
        if (cores := len(os.sched_getaffinity(0))) > 1:
            timed[f"replay, {cores} processes"] = lambda: replay(cores)
        best = dict.fromkeys(timed, float("inf"))
        for _ in range(ROUNDS):
            for name, run in timed.items():
                watch(name)
                best[name] = min(best[name], run())
    return [ReplayRow(name, 1e6 * took / cycles, seconds / took) for name, took in best.items()]


def markdown(rows: list[ReplayRow]) -> str:
    """Return the table, with each row's time relative to the first's."""
    lines = ["| | us a cycle | times real time | to the step |", "| --- | --- | --- | --- |"]
    for row in rows:
        lines.append(f"| {row.name} | {row.cycle_us:.0f} | {row.speed:.0f} | {row.cycle_us / rows[0].cycle_us:.2f} |")
    return "\n".join(lines)
