"""Messages from frames: the tip's pose in the base's frame, or the last one marked invalid with the reason."""

from collections import Counter

from tendond.drivers.mocap.frames import Frame
from tendond.drivers.mocap.geometry import WORLD, Alignment, Placement, continued
from tendond.drivers.mocap.level import Level
from tendond.schemas.base import Vector3
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.messages import TipPose

MISSING = "not in the stream"
HIDDEN = "hidden"
TURNED = "base turned against gravity"


class PoseBuilder:
    """One message per frame.

    Args:
        section: [mocap] or [vicon]. gravity: of the model, in the base's frame [m/s^2].
        base: pose of the base in the cameras' world, where no object shows it.

    Attributes:
        objections: reasons for which the last frame gave no valid pose; empty when it did.
        counts: frames without a valid pose, by reason.
        level: level of the base.
    """

    def __init__(self, section: ViconSection, gravity: Vector3, base: Placement = WORLD) -> None:
        self._section = section
        self._base = base
        self._alignment = Alignment(section, gravity)
        self.level = Level(self._alignment, gravity)
        self._last: TipPose | None = None
        self._seq = 0
        self.objections: tuple[str, ...] = ()
        self.counts: Counter[str] = Counter()

    def build(self, frame: Frame) -> TipPose | None:
        """Build the message for a frame; none before the first pose."""
        stamp_ns = max(0, frame.stamp_ns - round(self._section.latency * 1e9))
        placement, objections = None, []
        tip, base = frame.objects.get(self._section.tip), self._base
        if tip is None:
            objections.append(self._absent(frame, self._section.tip))
        if self._section.base:
            found = frame.objects.get(self._section.base)
            if found is None:
                objections.append(self._absent(frame, self._section.base))
            else:
                base = found
                self.level.see(base)
        if not objections and self._alignment.gravity_error(base) > self._section.gravity_tolerance:
            objections.append(TURNED)
        if tip is not None and not objections:
            placement = self._alignment.tip_in_base(tip, base)
        self.objections = tuple(objections)
        for objection in objections:
            self.counts[objection] += 1
        if placement is None:
            if self._last is None:
                return None
            pose = self._last.model_copy(update={"seq": self._seq, "stamp_ns": stamp_ns, "valid": False})
        else:
            x, y, z = placement.position.tolist()
            pose = TipPose(
                seq=self._seq,
                stamp_ns=stamp_ns,
                position=(x, y, z),
                orientation=continued(placement.rotation, None if self._last is None else self._last.orientation),
            )
        self._seq += 1
        self._last = pose
        return pose

    def _absent(self, frame: Frame, name: str) -> str:
        return f"'{name}' {frame.faults.get(name) or (HIDDEN if name in frame.objects else MISSING)}"
