"""Parameters that can be identified, by name; vectors component by component, and their names on the command line."""

from collections.abc import Iterable, Iterator

from tendond.daemon.errors import UsageError
from tendond.offline.identification.parameter import Parameter

MAX_TENDONS = 16
"""Largest number of tendons of a robot."""


def _factor(
    name: str, unit: str, meaning: str, section: str, key: str, *, force: bool = False, span: float = 20.0,
    max_error: float = 0.25, group: str = "",
) -> Parameter:  # fmt: skip
    return Parameter(name, unit, meaning, section, key, 0.0, 1.0 / span, span, force, max_error, group)


def _vectors() -> Iterator[Parameter]:
    """Yield the components of vectors; lengths and curvatures are for a robot of 1 m, see `parameters_of`."""
    for axis in "xyz":
        meaning = f"{axis} of the mass on the tip, from the tip"
        yield Parameter(
            f"tip_offset_{axis}", "m", meaning, "rod", "tip_offset", 1e-3, -0.2, 0.2, max_error=2e-3, group="tip_offset"
        )  # fmt: skip
    for axis in "xy":
        meaning = f"curvature without load about {axis}"
        yield Parameter(
            f"precurvature_{axis}", "1/m", meaning, "rod", "precurvature", 0.1, -6.0, 6.0, max_error=0.1,
            group="precurvature",
        )  # fmt: skip
    for axis in "xyz":
        meaning = f"shift of the base along {axis}, in the frame of the poses"
        yield Parameter(
            f"base_{axis}", "m", meaning, "rod.base", "position", 2e-3, -1.0, 1.0, max_error=0.01, group="base_position"
        )  # fmt: skip
    for axis in "xyz":
        meaning = f"turn of the base about {axis}, component of a rotation vector, in the frame of the poses"
        yield Parameter(
            f"base_turn_{axis}", "rad", meaning, "rod.base", "orientation", 0.02, -1.6, 1.6, max_error=0.05,
            group="base_rotation",
        )  # fmt: skip
    for i in range(MAX_TENDONS):
        meaning = f"true displacement of tendon {i} where zero is reported; negative: slack"
        yield Parameter(f"zero_{i}", "m", meaning, "", "", 1e-3, -0.05, 0.05, max_error=1e-3, group="zeros")
    for i in range(MAX_TENDONS):
        meaning = f"factor on the distance of tendon {i} from the backbone"
        yield _factor(
            f"radius_{i}", "-", meaning, "rod.scale", "tendon_radius", span=2.0, max_error=0.1, group="radii"
        )  # fmt: skip


PARAMETERS: dict[str, Parameter] = {
    parameter.name: parameter
    for parameter in (
        _factor("E", "Pa", "Young's modulus", "rod", "youngs_modulus", force=True),
        _factor("rho", "kg/m^3", "density, with disks, glue and markers", "rod", "density", force=True),
        _factor("Bbt", "N m^2 s", "bending damping", "rod", "bending_damping", force=True, span=100.0),
        _factor("C", "kg/m^2", "square-law drag", "rod", "drag", force=True, span=100.0),
        _factor("tendon_stiffness", "N/m", "of each tendon", "rod", "tendon_stiffness", force=True, span=100.0),
        Parameter(
            "tip_mass",
            "kg",
            "of a body on the tip, beside a known weight",
            "rod",
            "tip_mass",
            0.01,
            0.0,
            1.0,
            force=True,
            max_error=0.001,
        ),
        _factor("spool", "-", "true over reported displacement", "servo", "spool_radius", span=2.0),
        Parameter("delay", "s", "age of a pose when it arrives", "observer", "delay", 0.01, 0.0, 0.3, max_error=0.005),
        Parameter("lag", "s", "time constant of the servos", "observer", "lag", 0.01, 1e-4, 0.5, max_error=0.01),
        Parameter("backlash", "m", "lost when a servo changes direction", "", "", 1e-4, 0.0, 0.005, max_error=1e-4),
        Parameter("zero", "m", "true displacement where zero is reported", "", "", 0.001, -0.02, 0.02, max_error=0.001),
        Parameter(
            "mu", "-", "friction of the tendons on their guides", "rod", "tendon_friction", 0.05, 0.0, 2.0,
            max_error=0.05,
        ),
        _factor(
            "radius", "-", "factor on all tendons' distances from the backbone", "rod.scale", "tendon_radius",
            span=2.0, max_error=0.1,
        ),
        *_vectors(),
    )
}  # fmt: skip
"""Parameters by name."""

DEFAULT = ("E", "rho", "Bbt", "C", "tendon_stiffness", "tip_mass", "delay", "lag", "spool", "backlash")

DYNAMIC = ("Bbt", "C", "delay", "lag")
"""Parameters that rests do not depend on."""

FROM = {"lag": 2e-3, "backlash": 2e-5, "tip_mass": 2e-3, "mu": 0.02}
"""Minimum start of a fit [s, m, kg, -]: at zero derivatives vanish, or their steps do."""

GENERAL = (
    "mu",
    "precurvature_x",
    "precurvature_y",
    *(f"base{part}_{axis}" for part in ("", "_turn") for axis in "xyz"),
)
"""Parameters that only the general rod has."""

ALIASES = {
    "youngs_modulus": ("E",), "density": ("rho",), "bending_damping": ("Bbt",), "drag": ("C",),
    "tendon_friction": ("mu",), "spool_radius": ("spool",), "tendon_radius": ("radius",), "slack": ("zero",),
    "base": tuple(f"base{part}_{axis}" for part in ("", "_turn") for axis in "xyz"),
}  # fmt: skip
"""Other names: keys of the configuration, and vectors of vectors."""


def members(name: str) -> tuple[str, ...]:
    """Return the names of the parameters that a name on the command line stands for; empty where it is unknown."""
    if name in PARAMETERS:
        return (name,)
    return ALIASES.get(name) or tuple(one.name for one in PARAMETERS.values() if one.group == name)


def names() -> list[str]:
    """Return the names that `chosen` takes, vectors by their own."""
    single = [name for name, one in PARAMETERS.items() if not one.group]
    return [*single, *dict.fromkeys(one.group for one in PARAMETERS.values() if one.group), "base"]


def chosen(wanted: Iterable[str]) -> tuple[Parameter, ...]:
    """Select parameters by name, in the order of `PARAMETERS`.

    Raises:
        UsageError: an unknown name, or none.
    """
    found: set[str] = set()
    for name in (one.strip() for one in wanted):
        if not name:
            continue
        if not (parts := members(name)):
            raise UsageError(f"--parameters: '{name}': choose among {', '.join(names())}")
        found.update(parts)
    if not found:
        raise UsageError(f"--parameters: choose among {', '.join(names())}")
    return tuple(parameter for parameter in PARAMETERS.values() if parameter.name in found)
