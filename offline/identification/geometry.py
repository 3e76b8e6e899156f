"""Parameters of friction, routing, precurvature, base and tip body in a configuration's [rod]."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from scipy.spatial.transform import Rotation

from tendond.offline.identification.parameter import Parameter
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.bodies import RodBase
from tendond.schemas.config.rod.scale import RodScale

AXES = "xyz"


def geometry_of(rod: RodSection, parameter: Parameter) -> Parameter | None:
    """Return a parameter with the key and the bounds that it has for this robot; none for a tendon that it lacks."""
    length, group = rod.backbone_length, parameter.group
    tendons = len(rod.tendon or rod.tendon_positions)
    if group in ("zeros", "radii") and int(parameter.name.rpartition("_")[2]) >= tendons:
        return None
    if parameter.key == "tendon_radius" and not rod.not_uniform:
        return replace(parameter, section="rod", key="tendon_positions")
    if group == "tip_offset" and rod.tip is not None:
        return replace(parameter, section="rod.tip", key="offset")
    if group == "precurvature":
        return _times(parameter, 1.0 / length)
    if group in ("base_position", "tip_offset"):
        return _times(parameter, length)
    return parameter


def _times(parameter: Parameter, factor: float) -> Parameter:
    return replace(
        parameter, scale=factor * parameter.scale, lower=factor * parameter.lower, upper=factor * parameter.upper,
        max_error=factor * parameter.max_error,
    )  # fmt: skip


def nominal_geometry(rod: RodSection) -> dict[str, float]:
    """Return the configured values by name: zero corrections of zeros and base, factors of one."""
    tendons = range(len(rod.tendon or rod.tendon_positions))
    factors = rod.scale.tendon_radius if rod.scale is not None else ()
    offset = rod.tip_offset if rod.tip is None else rod.tip.offset
    return {
        "mu": rod.tendon_friction,
        "radius": 1.0,
        **{f"radius_{i}": factors[i] if factors else 1.0 for i in tendons},
        **{f"zero_{i}": 0.0 for i in tendons},
        **{f"precurvature_{axis}": rod.precurvature[i] for i, axis in enumerate("xy")},
        **{f"base_{axis}": 0.0 for axis in AXES},
        **{f"base_turn_{axis}": 0.0 for axis in AXES},
        **{f"tip_offset_{axis}": offset[i] for i, axis in enumerate(AXES)},
    }


def with_geometry(rod: RodSection, values: Mapping[str, float]) -> RodSection:
    """Return [rod] with these values; those that are not given stay, and so does what equals the configuration."""
    was = nominal_geometry(rod)
    given = {name: values[name] for name in was if name in values}
    changed = {name for name, value in given.items() if value != was[name]}
    if not changed:
        return rod
    now = was | given
    update: dict[str, Any] = {}
    if "mu" in changed:
        update["tendon_friction"] = now["mu"]
    if any(name.startswith("precurvature") for name in changed):
        update["precurvature"] = (now["precurvature_x"], now["precurvature_y"], rod.precurvature[2])
    if any(name.startswith("radius") for name in changed):
        update |= _spread(rod, now)
    if any(name.startswith("tip_offset") for name in changed):
        x, y, z = (now[f"tip_offset_{axis}"] for axis in AXES)
        update |= (
            {"tip_offset": (x, y, z)} if rod.tip is None else {"tip": rod.tip.model_copy(update={"offset": (x, y, z)})}
        )
    return rod.model_copy(update=update)


def _spread(rod: RodSection, now: Mapping[str, float]) -> dict[str, Any]:
    """Return the key with the tendons' distances: their places where the robot is uniform, else factors."""
    factors = tuple(now["radius"] * now[f"radius_{i}"] for i in range(len(rod.tendon or rod.tendon_positions)))
    if rod.not_uniform:
        return {"scale": (rod.scale or RodScale()).model_copy(update={"tendon_radius": factors})}
    places = zip(factors, rod.tendon_positions, strict=True)
    return {"tendon_positions": tuple((factor * x, factor * y) for factor, (x, y) in places)}


def base_turn(values: Mapping[str, float]) -> Rotation:
    """Return the turn of the base, in the frame of the poses: the configured base's."""
    return Rotation.from_rotvec([values[f"base_turn_{axis}"] for axis in AXES])


def base_shift(values: Mapping[str, float]) -> tuple[float, float, float]:
    """Return the shift of the base [m], in the frame of the poses: the configured base's."""
    return values["base_x"], values["base_y"], values["base_z"]


def moved_base(base: RodBase, values: Mapping[str, float]) -> RodBase:
    """Return the base in the world, shifted and turned in its own frame; gravity stays."""
    w, x, y, z = base.orientation
    own, turn = Rotation.from_quat([x, y, z, w]), base_turn(values)
    qx, qy, qz, qw = map(float, (own * turn).as_quat())
    a, b, c = (float(one) for one in base.position + own.apply(base_shift(values)))
    found: dict[str, Any] = {"position": (a, b, c), "orientation": (qw, qx, qy, qz)}
    if base.down is not None:
        found["down"] = tuple(float(one) for one in turn.inv().apply(base.down))
    return base.model_copy(update=found)
