"""Jumps of the measured tip: a tip has mass, and does not move by a jump and rest before and after."""

from dataclasses import dataclass

from tendond.daemon.control.commissioning.tracking import TrackingBounds
from tendond.schemas.base import Vector3

BEFORE_AND_AFTER = 0.3
"""Motion in the poses before and after a jump, of the jump, that shows a tip that really moved. Chosen;
`tendond study robustness` has no false alarm with it, and `pytest tests/unit/control/monitors` misses no jump."""

POSES_AFTER = 3
"""Number of poses in a row in which a tip that has jumped moves no further. One that was hit springs back: stiff
tendons, noise and the turning point of a push of a single cycle leave one small step, not three."""


@dataclass(frozen=True)
class JumpWatch:
    """The last steps of the measured tip.

    Attributes:
        last_step: size of the newest step [m]; per cycle, as `step_size`.
        origin: position of the tip before a step that looks like a jump [m]; none without one.
        step_size: size of that step [m].
        persistent: a tip has jumped and rests where it jumped to.
        pose_distrusted: the pose before the newest one was not believed: a difference of the two is no speed.
        rested: poses since such a step in which the tip stayed where it had gone to.
        gap_cycles: cycles over which the distance to the newest pose may be spread: delayed poses come in quick
            succession afterwards, and each of them then goes further than its own interval says.
    """

    last_step: float = 0.0
    origin: Vector3 | None = None
    step_size: float = 0.0
    persistent: bool = False
    pose_distrusted: bool = False
    rested: int = 0
    gap_cycles: int = 1

    @property
    def withheld(self) -> bool:
        """True if the newest pose is not to be believed yet."""
        return self.origin is not None


def watch_jump(
    bounds: TrackingBounds, watch: JumpWatch, interval: int, distance: float, change: float, before: Vector3
) -> JumpWatch:
    """Return the watch after a fresh pose.

    A tip has mass: it does not move by a jump in one interval, and rest before and after. One that goes on moving was
    hit; one that is back was seen wrongly once.

    Args:
        bounds: bounds of what is tolerated. watch: so far.
        interval: cycles since the pose before.
        distance: travelled by the measured tip since then [m].
        change: change of measured against model tip since then [m].
        before: measured tip before the step [m].
    """
    gap = max(interval, watch.gap_cycles - 1)
    step = distance / gap
    if watch.origin is not None:
        if step >= BEFORE_AND_AFTER * watch.step_size:
            return JumpWatch(step, step_size=watch.step_size, pose_distrusted=True, gap_cycles=gap)
        rested = watch.rested + 1
        if rested < POSES_AFTER:
            return JumpWatch(step, origin=watch.origin, step_size=watch.step_size, rested=rested, gap_cycles=gap)
        return JumpWatch(
            step, persistent=True, step_size=watch.step_size, pose_distrusted=True, rested=rested, gap_cycles=gap
        )
    sudden = min(distance, change) > bounds.jump * gap and watch.last_step < BEFORE_AND_AFTER * step
    return JumpWatch(step, origin=before if sudden else None, step_size=step, gap_cycles=gap)
