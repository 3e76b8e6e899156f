"""Cycle records made by hand, for what reads and writes them."""

from collections.abc import Sequence

from tendond.schemas.base import Vector3
from tendond.schemas.messages import Mode, TendonCommand, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord, ModelState, ReferencePoint, TipEstimate

ZERO = (0.0, 0.0, 0.0)
UPRIGHT = (1.0, 0.0, 0.0, 0.0)


def cycle_record(
    tick: int,
    measured: Vector3 | None = (0.1, 0.0, 0.4),
    mode: Mode = Mode.TRACKING,
    displacement: float = 0.01,
    terms: Sequence[float] = (1 / 3, -0.1),
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
        reference=ReferencePoint(position=(0.34, 0.0, 0.0398), velocity=ZERO, acceleration=ZERO),
        estimate=TipEstimate(position=ZERO, velocity=ZERO, acceleration=ZERO, offset=ZERO),
        terms={"z1": tuple(terms)},
        wanted=tension,
        tension=tension,
        limited=(),
        model=ModelState(position=ZERO, orientation=UPRIGHT, residual=1e-9, marches=2),
        command=TendonCommand(seq=tick, stamp_ns=tick, pose_seq=tick, displacement=pulled, tension=tension, armed=True),
    )
