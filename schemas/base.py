"""The base of everything that crosses a boundary: frozen, finite, nothing unknown."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

SCHEMA_VERSION: Literal[1] = 1

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z; body to world."""

PerTendon = Annotated[tuple[float, ...], Field(min_length=1, max_length=16)]
"""One number per tendon, in the order of the rig's configuration."""


class Schema(BaseModel):
    """Frozen, strict about unknown keys, and without NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="constants")
