"""[rod.tip] and [rod.base]: the body on the tip, and how the robot is mounted."""

import math
from typing import Annotated

from pydantic import Field, model_validator

from tendond.schemas.base import Quaternion, Schema, Vector3
from tendond.schemas.config.ranges import NotNegative


class RodTip(Schema):
    """[rod.tip]: a tool or marker body, fixed to the tip."""

    mass: Annotated[float, Field(gt=0.0, le=10.0, description="its mass [kg]")]
    inertia: tuple[NotNegative, NotNegative, NotNegative] = Field(
        (0.0, 0.0, 0.0), description="inertia about its centre of mass, diagonal, body frame [kg m^2]"
    )
    offset: Vector3 = Field((0.0, 0.0, 0.0), description="from the tip to its centre of mass, body frame [m]")


class RodBase(Schema):
    """[rod.base]: pose of the base in the world, and gravity's direction in it; the bus is in the base's frame."""

    position: Vector3 = Field((0.0, 0.0, 0.0), description="of the base, world frame [m]")
    orientation: Quaternion = Field(
        (1.0, 0.0, 0.0, 0.0), description="of the base, body to world, quaternion w, x, y, z [-]; the rod leaves on +z"
    )
    down: Vector3 | None = Field(
        None, description="direction of gravity in the base's own axes, of any length [-]; instead of rod.gravity"
    )

    @model_validator(mode="after")
    def _directions(self) -> "RodBase":
        wrong = []
        if not math.isclose(math.hypot(*self.orientation), 1.0, abs_tol=1e-3):
            wrong.append("orientation: must have the length 1")
        if self.down is not None and math.hypot(*self.down) < 1e-6:
            wrong.append("down: must not be zero: give gravity = [0, 0, 0] in [rod] for none")
        if wrong:
            raise ValueError("\n".join(wrong))
        return self

    @property
    def has_pose(self) -> bool:
        """True if it is not at the world's origin, or turned against the world."""
        return any(self.position) or any(self.orientation[1:])

    def to_world(self, vector: Vector3) -> Vector3:
        """Turn a vector from the base's axes into the world's."""
        w, x, y, z = self.orientation
        return _turned(vector, w, x, y, z)

    def own_gravity(self, gravity: Vector3) -> Vector3:
        """Return gravity in the base's frame [m/s^2]: along `down` of the size of `gravity`, else that, turned."""
        if self.down is None:
            w, x, y, z = self.orientation
            return _turned(gravity, w, -x, -y, -z) if any((x, y, z)) else gravity
        x, y, z = self.down
        size, norm = math.hypot(*gravity), math.hypot(x, y, z)
        return size * x / norm, size * y / norm, size * z / norm


def _turned(vector: Vector3, w: float, x: float, y: float, z: float) -> Vector3:
    """Turn a vector by a quaternion of nearly unit length."""
    norm = math.hypot(w, x, y, z)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    a, b, c = vector
    return (
        (1.0 - 2.0 * (y * y + z * z)) * a + 2.0 * (x * y - w * z) * b + 2.0 * (x * z + w * y) * c,
        2.0 * (x * y + w * z) * a + (1.0 - 2.0 * (x * x + z * z)) * b + 2.0 * (y * z - w * x) * c,
        2.0 * (x * z - w * y) * a + 2.0 * (y * z + w * x) * b + (1.0 - 2.0 * (x * x + y * y)) * c,
    )
