"""Goals from ROS 2, checked, as requests for a reference; whether the robot reaches them the controller decides."""

import math
from typing import Any

from pydantic import ValidationError

from tendond.drivers.ros2.messages import RigMessages
from tendond.drivers.ros2.topics import POINT, POSE
from tendond.drivers.ros2.types import MalformedError
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import QUATERNION_TOLERANCE
from tendond.schemas.mistaken_units import unit_hint
from tendond.schemas.requests import ControlAction, ControlRequest

AGE_MAX = 1.0
"""Largest age of a goal or a call by its stamp [s]. Chosen: a person's next click takes longer, a network does not."""

AHEAD_MAX = 0.5
"""Time by which a stamp may be ahead of this host's clock [s]: hosts without a common clock are further apart."""

REACH = 2.0
"""Largest distance of a goal from the base, in lengths of the arm, as for `tendond rig reference`."""

IN_PLANE = ("exponential", "step", "minimum_jerk")
KEPT = (
    *("branch", "unreachable", "path", "rate", "duration", "moved_max", "turned_max", "posture", "timing"),
    *("speed_max", "acceleration_max", "jerk_max"),
)
"""Keys of [reference] that a goal leaves as they are configured."""


class RefusedError(Exception):
    """A goal or a call that is not passed on; the text says why."""


def check_stamp(stamp_ns: int, now_ns: int, what: str) -> None:
    """Refuse what is old, and what is from the future, by wall-clock times [ns].

    Raises:
        RefusedError: with the age, and what to do.
    """
    if stamp_ns == 0:
        raise RefusedError(f"{what} has no stamp: set it to the time at which it is sent")
    age = 1e-9 * (now_ns - stamp_ns)
    if age > AGE_MAX:
        raise RefusedError(
            f"{what} is {age:.1f} s old, up to {AGE_MAX:g} s are allowed: send it again, or set the clocks"
        )
    if age < -AHEAD_MAX:
        raise RefusedError(f"{what} is {-age:.1f} s ahead of this host's clock: synchronise the clocks")


def goal_request(
    config: RigConfig, messages: RigMessages, type_name: str, payload: bytes, now_ns: int
) -> ControlRequest:
    """Return the request for a reference that ends in a goal.

    Args:
        config: of the rig, whose [reference] gives everything but the target.
        messages: of the rig, for its frames.
        type_name: PointStamped or PoseStamped, as ROS has it.
        payload: CDR.
        now_ns: wall-clock time [ns].

    Raises:
        RefusedError: it is malformed, old, not finite, in another frame, out of reach, or not for this rig.
    """
    what = "goal_point" if type_name == POINT else "goal_pose"
    try:
        goal: Any = messages.types.decode(type_name, payload)
    except MalformedError as error:
        raise RefusedError(f"{what} is malformed: {error}") from error
    header = goal.header
    check_stamp(int(header.stamp.sec) * 1_000_000_000 + int(header.stamp.nanosec), now_ns, what)
    if header.frame_id != messages.base:
        raise RefusedError(f"{what} is in frame '{header.frame_id[:64]}': give it in '{messages.base}'")
    place = goal.point if type_name == POINT else goal.pose.position
    position = (float(place.x), float(place.y), float(place.z))
    _check_position(position, config.rod.backbone_length, what)
    orientation = _orientation(goal.pose.orientation, what) if type_name == POSE else None
    try:
        section = ReferenceSection.model_validate(_table(config.reference, position, orientation))
    except ValidationError as error:
        raise RefusedError(f"{what} is no reference of this rig: {error.errors()[0]['msg']}") from error
    return ControlRequest(action=ControlAction.REFERENCE, reference=section)


def _check_position(position: Vector3, length: float, what: str) -> None:
    if not all(math.isfinite(value) for value in position):
        raise RefusedError(f"{what} is not finite")
    if math.hypot(*position) > REACH * length:
        farthest = max(position, key=abs)
        raise RefusedError(
            f"{what} is {math.hypot(*position):g} m away, out of reach of the arm, which is {length:g} m long"
            f"{unit_hint(farthest, REACH * length, 'm')}"
        )


def _orientation(found: Any, what: str) -> Quaternion:
    orientation = (float(found.w), float(found.x), float(found.y), float(found.z))
    norm = math.hypot(*orientation)
    if not math.isfinite(norm) or abs(norm - 1.0) > QUATERNION_TOLERANCE:
        raise RefusedError(f"{what} has no unit quaternion (norm {norm:.6g})")
    return orientation


def _table(configured: ReferenceSection, position: Vector3, orientation: Quaternion | None) -> dict[str, Any]:
    """Return the keys of a reference of the configured kind with another target."""
    kept = {name: getattr(configured, name) for name in KEPT if name in configured.model_fields_set}
    if configured.has_poses:
        turned = {} if orientation is None else {"orientation": orientation}
        return {**kept, "kind": "pose", "position": position, **turned}
    if orientation is not None:
        raise RefusedError(
            f"goal_pose has an orientation, which reference.kind = '{configured.kind}' cannot take: "
            "send a PointStamped to goal_point, or configure kind = 'pose'"
        )
    if configured.in_space:
        return {**kept, "kind": "point", "position": position}
    kind = configured.kind if configured.kind in IN_PLANE else "minimum_jerk"
    return {**kept, "kind": kind, "position": position}
