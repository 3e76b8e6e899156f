"""[rod.scale]: factors on the robot as it is described otherwise, as an identification finds them."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from tendond.schemas.base import Schema

Factor = Annotated[float, Field(ge=0.001, le=1000.0)]


class RodScale(Schema):
    """[rod.scale]: factors on the robot, all sections alike; `tendond identify` finds them for a robot of sections."""

    stiffness: Factor = Field(1.0, description="factor on the stiffness of all sections [-]")
    mass: Factor = Field(1.0, description="factor on the mass of all sections and disks, not of rod.tip [-]")
    damping: Factor = Field(1.0, description="factor on the damping of all sections, that by ratios too [-]")
    drag: Factor = Field(1.0, description="factor on the drag of all sections [-]")
    tendon_stiffness: Factor = Field(1.0, description="factor on the stiffness of all tendons that are given one [-]")
    tendon_radius: tuple[Factor, ...] = Field(
        (), max_length=16, description="factors on the tendons' distances from the backbone, one each [-]; default: 1"
    )

    def on_keys(self, keys: Mapping[str, Any]) -> dict[str, Any]:
        """Return the keys of the short form that these factors change, from their values without them."""
        by_key = {
            "youngs_modulus": self.stiffness, "density": self.mass, "bending_damping": self.damping,
            "shear_damping": self.damping, "drag": self.drag, "tendon_stiffness": self.tendon_stiffness,
        }  # fmt: skip
        found = {key: _times(factor, keys[key]) for key, factor in by_key.items() if keys.get(key) is not None}
        if self.tendon_radius and "tendon_positions" in keys:
            pairs = zip(self.tendon_radius, keys["tendon_positions"], strict=True)
            found["tendon_positions"] = tuple(_times(factor, place) for factor, place in pairs)
        return found

    def unmatched(self, tendons: int) -> Iterator[str]:
        """Find factors on tendons that do not exist; yield what is wrong with them."""
        if len(self.tendon_radius) not in (0, tendons):
            yield f"scale.tendon_radius: has {len(self.tendon_radius)} factors for {tendons} tendons: give one each"


def _times(factor: float, value: Any) -> Any:
    return tuple(factor * one for one in value) if isinstance(value, tuple) else factor * value
