"""[rod]: geometry, material, damping and tendons of the robot."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from tendond.schemas import paper_robot
from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import NotNegative, Positive
from tendond.schemas.config.rod.bodies import RodBase, RodTip
from tendond.schemas.config.rod.inherit import HEADINGS, SHORT_FORM, damped_themselves, over
from tendond.schemas.config.rod.mean_wire import mean_keys
from tendond.schemas.config.rod.presets import PRESETS, PresetName
from tendond.schemas.config.rod.scale import RodScale
from tendond.schemas.config.rod.section import BackboneSection
from tendond.schemas.config.rod.short_form import NotShortError, backbone_keys, damping_of, tendon_keys
from tendond.schemas.config.rod.tendon import RodTendon, beyond, frictions_of

Diagonal = tuple[NotNegative, NotNegative, NotNegative]


class RodSection(Schema):
    """[rod] and [simulator.rod]: the robot, one straight uniform section; the defaults are the paper's.

    [[rod.section]], [[rod.tendon]], [rod.tip] and [rod.base] describe any other robot. [simulator.rod] has the values
    of [rod] where it gives none.
    """

    preset: PresetName | None = Field(None, description="robot by name, whose values hold where no other are given")
    length: Annotated[float, Field(gt=0.0, le=10.0, description="length of the backbone [m]")] = paper_robot.LENGTH
    radius: Annotated[float, Field(gt=0.0, le=0.1, description="radius of the backbone [m]")] = paper_robot.RADIUS
    youngs_modulus: Annotated[float, Field(ge=1e6, le=1e12, description="Young's modulus of the backbone [Pa]")] = (
        paper_robot.YOUNGS_MODULUS
    )
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="Poisson's ratio of the backbone [-]")] = (
        paper_robot.POISSON_RATIO
    )
    density: Annotated[
        float, Field(gt=0.0, le=1e6, description="density of the backbone with disks, glue and markers [kg/m^3]")
    ] = paper_robot.DENSITY
    shear_damping: Diagonal = Field(
        paper_robot.SHEAR_DAMPING, description="damping of shear and extension, diagonal of Bse [N s]"
    )
    bending_damping: Diagonal = Field(
        paper_robot.BENDING_DAMPING, description="damping of bending and torsion, diagonal of Bbt [N m^2 s]"
    )
    damping_ratio: Annotated[float, Field(ge=0.0, le=2.0)] | None = Field(
        None, description="damping ratio of the first bending mode [-]; instead of bending_damping"
    )
    outer_radius: Positive | None = Field(
        None, description="distance of the outermost fibre from the axis, for strain [m]; default: radius"
    )
    yield_strain: Annotated[float, Field(gt=0.0, le=10.0)] | None = Field(
        None, description="strain that the backbone bears without a permanent bend [-]; default: by its modulus"
    )
    drag: Diagonal = Field(paper_robot.DRAG, description="drag of the air, diagonal of C [kg/m^2]")
    gravity: Vector3 = Field(
        paper_robot.GRAVITY,
        description="gravity in the world frame, in which the straight rod lies on +z unless rod.base turns it [m/s^2]",
    )
    tendon_positions: Annotated[
        tuple[tuple[float, float], ...],
        Field(min_length=1, max_length=16, description="position (x, y) of each tendon in the cross-section [m]"),
    ] = paper_robot.TENDON_POSITIONS
    tip_mass: Annotated[float, Field(ge=0.0, le=10.0, description="mass of a tool or marker body on the tip [kg]")] = (
        0.0
    )
    tip_inertia: Diagonal = Field(
        (0.0, 0.0, 0.0), description="inertia of that body about its centre of mass, diagonal, body frame [kg m^2]"
    )
    tip_offset: Vector3 = Field(
        (0.0, 0.0, 0.0), description="centre of mass of that body, from the tip, body frame [m]"
    )
    tendon_stiffness: Positive | None = Field(
        None, description="stiffness of a whole tendon [N/m]; default: inextensible"
    )
    tendon_friction: Annotated[
        float, Field(ge=0.0, le=2.0, description="coefficient of friction of the tendons on their guides [-]")
    ] = 0.0
    precurvature: Vector3 = Field(
        (0.0, 0.0, 0.0), description="curvature without load, added to that of all sections: about x, y, z [1/m]"
    )
    section: tuple[BackboneSection, ...] = Field(
        (), max_length=16, description="sections from the base on; instead of length, radius and the like"
    )
    tendon: tuple[RodTendon, ...] = Field((), max_length=16, description="tendons; instead of tendon_positions")
    tip: RodTip | None = None
    base: RodBase | None = None
    scale: RodScale | None = None
    space: Literal["euler", "rk4", "rk6"] = Field(
        "rk6", description="integration scheme along the rod; euler is the paper's"
    )
    nodes: (
        Annotated[
            int,
            Field(
                ge=2,
                le=2000,
                description="number of nodes along the rod; default: the scheme's own",
            ),
        ]
        | None
    ) = None
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, description="parameter of the BDF-alpha scheme in time [-]")] = -0.2

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, data: Any) -> Any:
        if isinstance(data, Mapping) and isinstance(name := data.get("preset"), str) and name in PRESETS:
            return over(PRESETS[name], data)
        return data

    @model_validator(mode="after")
    def _one_description(self) -> "RodSection":
        if wrong := [*self._twice(), *beyond(self.tendon, self.backbone_length), *self._unmatched()]:
            raise ValueError("\n".join(wrong))
        try:
            values = self._short_form()
            values |= {"section": (), "tendon": (), "tip": None, "damping_ratio": None, "scale": None}
            if self.base is not None and not self.base.has_pose:
                values["base"] = None
        except NotShortError:
            values = self._outline()
        for name, value in values.items():
            object.__setattr__(self, name, value)  # frozen for everyone else
        return self

    def _twice(self) -> Iterator[str]:
        """Find what is described twice."""
        given = {name for name in self.model_fields_set if getattr(self, name) is not None}
        for table, short in SHORT_FORM.items():
            if getattr(self, table):
                yield from (
                    f"{name}: is described by {HEADINGS[table]} too: remove one of them"
                    for name in short
                    if name in given
                )
        if not self.section and {"damping_ratio", "bending_damping"} <= given:
            yield "damping_ratio: is described by bending_damping too: remove one of them"
        if "damping_ratio" in given and damped_themselves(self.section):
            yield "damping_ratio: has no effect: every [[rod.section]] has a damping of its own: remove one of them"
        if self.base is not None and self.base.down is not None and "gravity" in given:
            yield "gravity: its direction is described by base.down too: remove one of them"

    def _unmatched(self) -> Iterator[str]:
        """Find factors on tendons that do not exist."""
        if self.scale is not None:
            yield from self.scale.unmatched(len(self.tendon or self.tendon_positions))

    def _short_form(self) -> dict[str, Any]:
        """Return the keys that describe the same robot without [[rod.section]] and the other tables.

        Raises:
            NotShortError: there are none.
        """
        found: dict[str, Any] = {}
        if any(self.precurvature):
            raise NotShortError("precurvature", "a rod that is curved without load")
        first = self.section[0] if self.section else None
        if first is not None:
            if len(self.section) > 1:
                raise NotShortError("section", f"{len(self.section)} sections")
            found |= backbone_keys(first)
        if self.tendon:
            found |= tendon_keys(self.tendon, self.backbone_length)
        if self.tip is not None:
            found |= {"tip_mass": self.tip.mass, "tip_inertia": self.tip.inertia, "tip_offset": self.tip.offset}
        if self.base is not None and self.base.down is not None:
            found["gravity"] = self.base_gravity
        ratio = self.damping_ratio if first is None or first.damping_ratio is None else first.damping_ratio
        if ratio is not None and (first is None or first.bending_damping is None):
            names = ("length", "radius", "youngs_modulus", "poisson_ratio", "density")
            known = {name: getattr(self, name) for name in (*names, "tip_mass", "tip_inertia", "tip_offset")}
            found["bending_damping"] = damping_of(ratio, known | found)
        return found if self.scale is None else found | self.scale.on_keys(dict(self) | found)

    def _outline(self) -> dict[str, Any]:
        """Length, mean wire, tendons at the base and gravity, for checks and limits of other tables."""
        found: dict[str, Any] = {"length": self.backbone_length, "gravity": self.gravity}
        if self.base is not None and self.base.down is not None:
            found["gravity"] = self.base_gravity
        if self.section:
            found |= mean_keys(self.section)
            found |= {} if self.scale is None else self.scale.on_keys(found)
        if self.tip is not None:
            found["tip_mass"] = self.tip.mass
        if self.tendon:
            found["tendon_positions"] = tuple(tendon.at_base for tendon in self.tendon)
        return found

    @model_serializer(mode="wrap")
    def _without_outline(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out the keys of the short form that a table replaces."""
        data: dict[str, Any] = handler(self)
        for table, short in SHORT_FORM.items():
            if getattr(self, table):
                data = {name: value for name, value in data.items() if name not in short}
        if self.base is not None and self.base.down is not None:
            data.pop("gravity", None)
        if self.damping_ratio is not None:  # of which bending_damping, the default here, is another description
            data.pop("bending_damping", None)
        return data

    @property
    def backbone_length(self) -> float:
        """Length of the whole backbone [m]."""
        return sum(section.length for section in self.section) if self.section else self.length

    @property
    def base_gravity(self) -> Vector3:
        """Gravity in the base's frame [m/s^2], in which controller and simulator work."""
        return self.gravity if self.base is None else self.base.own_gravity(self.gravity)

    @property
    def world_gravity(self) -> Vector3:
        """Gravity in the world frame [m/s^2]."""
        return self.gravity if self.base is None else self.base.to_world(self.base_gravity)

    @property
    def not_uniform(self) -> str:
        """Key and reason for which the shooting rod does not describe this robot; empty where it does."""
        try:
            self._short_form()
        except NotShortError as error:
            return str(error)
        return ""

    @property
    def has_elastic_tendons(self) -> bool:
        """True if a tendon is given a stiffness."""
        return self.tendon_stiffness is not None or any(one.stiffness is not None for one in self.tendon)

    @property
    def frictions(self) -> tuple[float, ...]:
        """Coefficient of friction of each tendon [-]."""
        return frictions_of(self.tendon, self.tendon_friction) or (self.tendon_friction,) * len(self.tendon_positions)

    def parameters(self) -> dict[str, Any]:
        """Return the keys of the short form that are parameters of `model.rod.RodParameters`."""
        names = (name for short in SHORT_FORM.values() for name in short if name != "outer_radius")
        found = {name: getattr(self, name) for name in names} | {"gravity": self.base_gravity}
        return {name: value for name, value in found.items() if value is not None}
