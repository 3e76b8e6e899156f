"""Cycle records made by hand, and logs of them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tendond.daemon.recording import scene
from tendond.daemon.recording.channels import CYCLE, ROD_SHAPE, TIMING
from tendond.daemon.recording.recorder import Recorder
from tendond.daemon.recording.run_files import CONFIG
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, TendonCommand, TipPose
from tendond.schemas.record import (
    CycleInputs,
    CycleRecord,
    LoopTiming,
    ModelState,
    ObserverEstimate,
    ReferencePoint,
    TipEstimate,
)

ZERO = (0.0, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)
TARGET = (0.34, 0.0, 0.0475)


def cycle_record(
    tick: int,
    measured: Vector3 | None = (0.1, 0.0, 0.4),
    mode: Mode = Mode.TRACKING,
    displacement: float = 0.01,
    terms: Sequence[float] = (1 / 3, -0.1),
    target: Vector3 = TARGET,
) -> CycleRecord:
    """A complete record of a rig with four tendons, of which the first is pulled by `displacement` [m]."""
    pulled = (displacement, 0.0, 0.0, 0.0)
    tension = (1000.0 * displacement, 0.0, 0.0, 0.0)
    return CycleRecord(
        tick=tick,
        time=0.01 * tick,
        mode=mode,
        reason="",
        inputs=CycleInputs(
            pose=None if measured is None else TipPose(seq=tick, stamp_ns=tick, position=measured, orientation=UPRIGHT)
        ),
        rejected=(),
        pose_age=0,
        measured=measured,
        reference=ReferencePoint(position=target, velocity=ZERO, acceleration=ZERO, target=target),
        observer=ObserverEstimate(innovation=ZERO, force=ZERO, pull=ZERO, offset=ZERO),
        estimate=TipEstimate(position=ZERO, velocity=ZERO, acceleration=ZERO),
        terms={"z1": tuple(terms)},
        wanted=tension,
        tension_estimate=tension,
        limited=(),
        model=ModelState(position=ZERO, orientation=UPRIGHT, residual=1e-9, marches=2),
        command=TendonCommand(seq=tick, stamp_ns=tick, pose_seq=tick, displacement=pulled, tension=tension, armed=True),
    )


def write_log(path: Path, records: Sequence[CycleRecord], config: RigConfig | None = None) -> Path:
    """A log with those cycles, a timing each, and a rod shape every fifth."""
    attached = (config or RigConfig()).model_dump_json()
    with Recorder(path, {"revision": "abc"}, {CONFIG: attached}, queue_size=100_000) as log:
        for record in records:
            log.put(CYCLE, record.tick, record)
            timing = LoopTiming(tick=record.tick, lateness_us=5.0, work_us=1000.0 + record.tick, missed_ticks=1)
            log.put(TIMING, record.tick, timing)
            if record.tick % 5 == 0:
                points = np.linspace(ZERO, record.measured or ZERO, 200)
                log.put(ROD_SHAPE, record.tick, scene.rod_shape(record.tick, record.tick, points, TARGET))
    assert log.error == ""
    return path
