"""Answers to the questions of `tendond config new`: how a text is read, and what makes no sense."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from tendond.schemas.config.rod.materials import MATERIALS
from tendond.schemas.errors.explain import choose
from tendond.schemas.errors.units import unit_hint

SUFFIXES = {
    "m": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "kg": {"kg": 1.0, "g": 1e-3},
    "-": {"": 1.0, "%": 1e-2},
    "Hz": {"hz": 1.0},
    "N/m": {"n/m": 1.0, "n/mm": 1e3},
}
"""Units that may stand behind a number, and their size in the unit of the question."""

GRAVITY = {
    "-x": (-9.81, 0.0, 0.0), "+x": (9.81, 0.0, 0.0), "-y": (0.0, -9.81, 0.0), "+y": (0.0, 9.81, 0.0),
    "-z": (0.0, 0.0, -9.81), "+z": (0.0, 0.0, 9.81), "none": (0.0, 0.0, 0.0),
}  # fmt: skip
"""Gravity by its direction in the base's axes: +x through tendon 0, +z along the straight robot."""

MODULUS, DENSITY = (1e6, 1e12), (300.0, 25e3)
"""Plausible Young's moduli [Pa] and densities [kg/m^3]: soft polymers to diamond, foam to tungsten."""


class AnswerError(ValueError):
    """An answer that cannot be used: what is allowed, in a line."""


def number(unit: str, low: float, high: float) -> Callable[[str], float]:
    """Return a reader of numbers within a plausible range, with or without a unit behind them.

    Args:
        unit: SI. low, high: plausible range, both allowed.
    """

    def read(text: str) -> float:
        match = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*([a-zA-Z/%]*)\s*", text)
        known = SUFFIXES.get(unit, {})
        suffix = match[2].lower() if match else ""
        if match is None or (suffix and suffix not in known):
            units = f" in {unit}, or with {', '.join(one for one in known if one)} behind it" if known else ""
            raise AnswerError(f"'{text}' is not a number{units}")
        try:
            value = float(match[1]) * (known[suffix] if suffix else 1.0)
        except ValueError:
            raise AnswerError(f"'{text}' is not a number") from None
        if not low <= value <= high:
            hint = "" if suffix else unit_hint(value, unit, lambda one: low <= one <= high)
            raise AnswerError(f"{value:g} {unit} is not within {low:g} to {high:g} {unit}{hint}")
        return value

    return read


def whole(low: int, high: int) -> Callable[[str], int]:
    """Return a reader of whole numbers in a range."""

    def read(text: str) -> int:
        if not re.fullmatch(r"\s*[0-9]+\s*", text) or not low <= int(text) <= high:
            raise AnswerError(f"'{text}' is not a whole number from {low} to {high}")
        return int(text)

    return read


def one_of(*names: str) -> Callable[[str], str]:
    """Return a reader of one of a few words."""

    def read(text: str) -> str:
        found = text.strip().lower()
        if found not in names:
            raise AnswerError(f"'{text}': {choose(text, names)}")
        return found

    return read


def material(text: str) -> dict[str, Any]:
    """Read a material by name, or its E [Pa] and density [kg/m^3] with a comma between.

    Returns:
        Keys of [rod], and `source` of their values.
    """
    name = text.strip().lower()
    if name in MATERIALS:
        found = MATERIALS[name]
        return {
            "youngs_modulus": found.youngs_modulus, "poisson_ratio": found.poisson_ratio, "density": found.density,
            "yield_strain": found.yield_strain, "source": f"{name}: {found.source}",
        }  # fmt: skip
    parts = text.split(",")
    if len(parts) != 2:
        known = choose(name, MATERIALS)
        raise AnswerError(f"'{text}': give E in Pa and the density in kg/m^3, 68e9,2700, or {known}")
    modulus, density = number("Pa", *MODULUS)(parts[0]), number("kg/m^3", *DENSITY)(parts[1])
    return {"youngs_modulus": modulus, "density": density, "source": "as given"}


@dataclass(frozen=True)
class Question:
    """A question.

    Attributes:
        flag: option that answers it. text: for people. default: the answer of --yes, as text.
        read: makes a value of a text, or raises `AnswerError`.
        of_robot: it is about the robot itself, which --like answers.
    """

    flag: str
    text: str
    default: str
    read: Callable[[str], Any]
    of_robot: bool = True

    @property
    def name(self) -> str:
        """Name of the answer."""
        return self.flag.removeprefix("--").replace("-", "_")


QUESTIONS = (
    Question("--length", "length of the backbone, from the clamp to the tip [m]", "0.3", number("m", 0.01, 10.0)),
    Question("--diameter", "diameter of the backbone [m]", "0.001", number("m", 1e-4, 0.05)),
    Question(
        "--material", f"material: {', '.join(MATERIALS)}; or E [Pa] and density [kg/m^3], as 68e9,2700",
        "spring-steel", material,
    ),
    Question(
        "--mass", "mass of backbone, disks, glue and markers together [kg]; 0: the bare backbone", "0",
        number("kg", 0.0, 10.0),
    ),
    Question("--tip-mass", "mass of a tool on the tip [kg]", "0", number("kg", 0.0, 10.0)),
    Question("--tendons", "number of tendons, evenly spaced about the axis; the first one on +x", "4", whole(1, 16)),
    Question("--tendon-radius", "distance of the tendons from the axis [m]", "0.01", number("m", 1e-4, 0.25)),
    Question(
        "--gravity", "gravity points to: -x (away from tendon 0), +x, -y, +y, -z (the robot stands), +z (hangs), none",
        "-x", one_of(*GRAVITY),
    ),
    Question(
        "--damping-ratio", "damping ratio of the first mode [-]: ln(a1/an) / (2 pi (n - 1)) after a pluck", "0.02",
        number("-", 0.0, 2.0),
    ),
    Question("--camera", "camera: none or vicon", "none", one_of("none", "vicon"), of_robot=False),
    Question("--servos", "servos: none or dynamixel", "none", one_of("none", "dynamixel"), of_robot=False),
    Question("--rate", "rate of the loop [Hz]", "100", number("Hz", 10.0, 1000.0), of_robot=False),
)  # fmt: skip
"""The questions, in their order."""


def contradictions(answers: Mapping[str, Any]) -> list[str]:
    """Find answers that do not fit together; a line each."""
    wrong = []
    length, diameter, radius = (answers.get(name) for name in ("length", "diameter", "tendon_radius"))
    if length and diameter and diameter > 0.2 * length:
        wrong.append(f"--diameter {diameter:g} m is more than a fifth of --length {length:g} m: no slender rod")
    if length and radius and radius > 0.5 * length:
        wrong.append(
            f"--tendon-radius {radius:g} m is more than half of --length {length:g} m"
            f"{unit_hint(radius, 'm', lambda one: one < 0.5 * length)}"
        )
    if diameter and radius and radius < 0.5 * diameter:
        wrong.append(f"--tendon-radius {radius:g} m lies inside a backbone of --diameter {diameter:g} m")
    return wrong
