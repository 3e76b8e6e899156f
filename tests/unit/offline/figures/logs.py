"""Logs made by hand for figures: several runs, gaps, injections."""

from collections.abc import Mapping
from pathlib import Path

from tendond.daemon.recording.channels import CYCLE, TRUTH
from tendond.daemon.recording.recorder import Recorder
from tendond.daemon.recording.run_files import CONFIG
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, SimulatorTruth
from tendond.schemas.record import CycleRecord
from tests.unit.offline.records import UPRIGHT, ZERO, cycle_record

__all__ = ["UPRIGHT", "approach", "truth", "write_simulated"]


def approach(first: int, count: int, target: float = 0.34) -> list[CycleRecord]:
    """Cycles that track from 0 to the target in x, and settle."""
    return [
        cycle_record(first + i, (target * (1.0 - 0.8**i), 0.0, 0.5 - 0.45 * (1.0 - 0.8**i)), displacement=0.05)
        for i in range(count)
    ]


def idle(first: int, count: int) -> list[CycleRecord]:
    """Cycles in which nothing moves."""
    return [cycle_record(first + i, (0.0, 0.0, 0.5), Mode.IDLE, 0.0) for i in range(count)]


def truth(tick: int, *injected: str) -> SimulatorTruth:
    """What a simulator says, with what it injects."""
    return SimulatorTruth(
        seq=tick, stamp_ns=0, position=ZERO, velocity=ZERO, displacement=(0.0,), tension=(0.0,), tip_force=ZERO,
        injected=injected,
    )  # fmt: skip


def write_simulated(
    path: Path, records: list[CycleRecord], injected: Mapping[int, str] | None = None, config: RigConfig | None = None
) -> Path:
    """Write a log with the truth of each cycle; `injected` are names by tick."""
    path.parent.mkdir(parents=True, exist_ok=True)
    found = injected or {}
    attached = (config or RigConfig()).model_dump_json()
    with Recorder(path, {"revision": "abc"}, {CONFIG: attached}, queue_size=100_000) as log:
        for record in records:
            log.put(CYCLE, record.tick, record)
            log.put(TRUTH, record.tick, truth(record.tick, *([found[record.tick]] if record.tick in found else [])))
    assert log.error == ""
    return path
