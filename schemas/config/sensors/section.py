"""[[sensors]]: one sensor beside the tip's pose, its rows, and its errors."""

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import NotNegative, Positive
from tendond.schemas.errors.keywords import WORDS, Node

SensorKind = Literal["markers", "curvature", "tension", "imu", "base"]

ROW_WIDTH: dict[SensorKind, int] = {"markers": 3, "curvature": 2, "tension": 1, "imu": 6, "base": 7}
"""Numbers of a row, by kind."""

TWO_UNITS: dict[SensorKind, str] = {"imu": "[rad/s, m/s^2]", "base": "[m, rad]"}
"""Kinds whose noise is two numbers, and their units."""

PLACED = {"at": ("markers", "curvature"), "offset": ("markers",), "tendons": ("tension",)}
"""Keys that say where a sensor measures, and the kinds that have them."""

MAX_ROWS = 64


def _as_rows(value: Any) -> Any:
    """Take three numbers for a list of one row."""
    return (
        [value]
        if isinstance(value, list | tuple) and not any(isinstance(one, list | tuple) for one in value)
        else value
    )


def _as_list(value: Any) -> Any:
    """Take a number for a list of one."""
    return value if isinstance(value, list | tuple) else [value]


def _array(items: Node, count: int | None = None) -> Node:
    """Return the JSON Schema of a list."""
    return {"type": "array", "items": items} | ({} if count is None else {"minItems": count, "maxItems": count})


_NUMBER: Node = {"type": "number"}
_ABOVE_ZERO: Node = {"type": "number", "exclusiveMinimum": 0}
Offsets = Annotated[
    tuple[Vector3, ...],
    BeforeValidator(_as_rows),
    Field(min_length=1, max_length=MAX_ROWS),
    WithJsonSchema(
        {
            "anyOf": [_array(_array(_NUMBER, 3)), _array(_NUMBER, 3)],
            WORDS: "3 numbers, or a list of such for each place",
        }
    ),
]
Noise = Annotated[
    tuple[Positive, ...],
    BeforeValidator(_as_list),
    Field(min_length=1, max_length=2),
    WithJsonSchema({"anyOf": [_array(_ABOVE_ZERO), _ABOVE_ZERO], WORDS: "a number > 0, or two for an imu and a base"}),
]


class SensorSection(Schema):
    """[[sensors]]: a sensor beside the tip's pose, whose readings a driver publishes on `<rig>/sensor/<name>`.

    A reading has one row for each place, tendon or body, SI units, in the base's frame where no other is named:
    markers x, y, z [m]; curvature u_x, u_y [1/m] about the cross-section's own axes; tension at the servo's end [N];
    imu of the tip angular rate x, y, z [rad/s] and acceleration minus gravity x, y, z [m/s^2], body frame; base x, y, z
    [m] and quaternion w, x, y, z, of the base in the frame in which it is configured.
    """

    name: Annotated[
        str, Field(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$", json_schema_extra={WORDS: "1 to 32 of a-z, 0-9, '-' and '_'"})
    ] = Field(description="its name, the last part of its key <rig>/sensor/<name>")
    kind: SensorKind = Field(
        description="what it measures; markers: positions along the rod; curvature: bending, by fibre gratings;"
        " tension: of the tendons, by load cells; imu: rates and acceleration of the tip; base: pose of a moving base"
    )
    at: Annotated[tuple[NotNegative, ...], Field(max_length=MAX_ROWS)] = Field(
        (), description="arc lengths of its places, from the base [m]; of markers and curvature"
    )
    offset: Offsets = Field(
        ((0.0, 0.0, 0.0),),
        description="of markers from the backbone, in the cross-section's frame [m]; one for all, or a list of them",
    )
    tendons: Annotated[tuple[Annotated[int, Field(ge=0, le=15)], ...], Field(max_length=16)] = Field(
        (), description="indices of the tendons that have a load cell; of tension"
    )
    noise: Noise = Field(
        description="standard deviation of each number, in its unit; of an imu of its rates and of its accelerations,"
        " of a base of its position and of its rotation vector"
    )
    delay: Annotated[float, Field(ge=0.0, le=0.5, description="age of a reading when it arrives [s]")] = 0.0
    timeout: Annotated[
        float, Field(gt=0.0, le=60.0, description="time without a reading that counts as silence [s]")
    ] = 0.2
    required: bool = Field(
        False, description="silence refuses arming and is a fault; false: it is only shown in the status"
    )
    rate: Positive | None = Field(
        None, description="readings per second of the simulated sensor [Hz]; default: one with each pose"
    )

    @model_validator(mode="after")
    def _fits_its_kind(self) -> "SensorSection":
        if wrong := [*self._places(), *self._numbers()]:
            raise ValueError("\n".join(wrong))
        return self

    def _places(self) -> Iterator[str]:
        """Find keys of places that the kind needs, or does not have."""
        for key, kinds in PLACED.items():
            if self.kind not in kinds and getattr(self, key) != type(self).model_fields[key].default:
                yield f"{key}: a sensor of kind '{self.kind}' has none: remove it"
        if self.kind in PLACED["at"] and not self.at:
            yield f"at: is missing: arc lengths of the {self.kind} [m]"
        if self.kind in PLACED["tendons"] and not self.tendons:
            yield "tendons: is missing: indices of the tendons that have a load cell"
        if len(set(self.tendons)) < len(self.tendons):
            yield "tendons: names a tendon twice"
        if self.kind == "markers" and self.at and len(self.offsets) != len(self.at):
            yield f"offset: has {len(self.offsets)} rows, at has {len(self.at)} places: give one for all, or one each"

    def _numbers(self) -> Iterator[str]:
        """Find numbers that do not fit the kind, or each other."""
        units = TWO_UNITS.get(self.kind)
        if len(self.noise) != (2 if units else 1):
            yield f"noise: must be {f'two numbers, {units},' if units else 'one number'} for kind '{self.kind}'"
        if self.rate is not None and self.rate * self.timeout <= 1.0:
            yield f"timeout: must be above the {1.0 / self.rate:g} s between two readings at rate = {self.rate:g} Hz"

    @property
    def rows(self) -> int:
        """Number of rows of a reading."""
        return len(self.at) or len(self.tendons) or 1

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return ROW_WIDTH[self.kind]

    @property
    def offsets(self) -> tuple[Vector3, ...]:
        """Offset of each place in the cross-section's frame [m]."""
        return self.offset * len(self.at) if len(self.offset) == 1 else self.offset

    @property
    def deviations(self) -> tuple[float, ...]:
        """Standard deviation of each measured number of a row, in its unit; of a base x, y, z and rotation vector."""
        return tuple(one for one in self.noise for _ in range(3)) if self.kind in TWO_UNITS else self.noise * self.width


def sensor_objections(sensors: tuple[SensorSection, ...], length: float, tendons: int) -> Iterator[str]:
    """Find what does not fit a robot of this length [m] and number of tendons, and names that are used twice."""
    seen: set[str] = set()
    for index, sensor in enumerate(sensors):
        if sensor.name in seen:
            yield f"sensors[{index}].name: '{sensor.name}' is the name of another sensor: give each its own"
        seen.add(sensor.name)
        if sensor.at and max(sensor.at) > length * (1.0 + 1e-9):
            yield f"sensors[{index}].at: {max(sensor.at):g} m lies beyond the backbone of {length:g} m"
        if sensor.tendons and max(sensor.tendons) >= tendons:
            yield f"sensors[{index}].tendons: {max(sensor.tendons)}, but the rod has tendons 0 to {tendons - 1}"
