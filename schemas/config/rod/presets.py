"""Robots by name, for `rod.preset`: parameters as their sources give them, and what those leave open."""

import math
from dataclasses import dataclass
from typing import Any, Literal

Tables = dict[str, Any]

PresetName = Literal["paper", "nitinol", "rucker-webster-2011", "till-2019", "rao-2021", "franka-tdcr-v4"]


def _around(count: int, radius: float, first: float = 0.0) -> list[tuple[float, float]]:
    """Places evenly about the axis, the first one at the angle `first` [rad]; rounded to 1 nm."""
    angles = [first + 2.0 * math.pi * index / count for index in range(count)]
    return [(round(radius * math.cos(a), 9) + 0.0, round(radius * math.sin(a), 9) + 0.0) for a in angles]


def _tendons(places: list[tuple[float, float]], end: float) -> list[Tables]:
    return [{"position": place, "end": end} for place in places]


PAPER: Tables = {}
"""R. Danesh, F. Janabi-Sharifi, arXiv:2412.12035 (2024), table 1: the defaults of [rod]."""

_NITINOL: Tables = {
    "length": 0.2, "radius": 7e-4, "youngs_modulus": 54e9, "mass_per_length": 0.0115,
    "disk_number": 10, "disk_mass": 2e-4,
}  # fmt: skip

NITINOL: Tables = {
    "length": 0.2,
    "radius": 7e-4,
    "youngs_modulus": 54e9,
    "density": round((0.0115 + 10 * 2e-4 / 0.2) / (math.pi * 7e-4**2), 1),
    "damping_ratio": 0.02,
    "drag": (0.0, 0.0, 0.0),
    "tendon_positions": _around(3, 0.01),
    "yield_strain": 0.06,
}
"""The proximal section of `RAO_2021` alone, its disks spread along it. The damping is an assumption."""

RUCKER_WEBSTER_2011: Tables = {
    "length": 0.242,
    "radius": 4e-4,
    "youngs_modulus": 210e9,
    "poisson_ratio": 0.3125,
    "density": 7850.0,
    "damping_ratio": 0.02,
    "drag": (0.0, 0.0, 0.0),
    "tendon_positions": _around(4, 0.008),
}
"""D. C. Rucker, R. J. Webster III, "Statics and dynamics of continuum robots with general tendon routing and external
loading", IEEE T-RO 27 (2011): the wire and its four straight tendons; G = 80 GPa. The density is that of bare steel,
the damping an assumption."""

TILL_2019: Tables = {
    "length": 0.7144,
    "radius": 6.75e-4,
    "youngs_modulus": 207e9,
    "density": round(0.034 / (0.7144 * math.pi * 6.75e-4**2), 1),
    "bending_damping": (5e-4, 5e-4, 5e-4),
    "drag": (1e-4, 1e-4, 1e-4),
    "gravity": (-9.81, 0.0, 0.0),
    "tendon_positions": ((0.01506, 0.0),),
    "tendon_stiffness": round(1.0 / 1.6e-3, 1),
}
"""J. Till, V. Aloi, D. C. Rucker, "Real-time dynamics of soft and continuum robots based on Cosserat-rod models", IJRR
38 (2019), with the values of the authors' published program: 34 g in all, one tendon with a compliance of 1.6 mm/N."""

RAO_2021: Tables = {
    "section": [{**_NITINOL}, {**_NITINOL}],
    "tendon": _tendons(_around(3, 0.01), 0.2) + _tendons(_around(3, 0.01), 0.4),
    "damping_ratio": 0.02,
    "gravity": (0.0, 0.0, 0.0),
    "yield_strain": 0.06,
}
"""P. Rao, Q. Peyron, S. Lilge, J. Burgner-Kahrs, "How to model tendon-driven continuum robots and benchmark modelling
performance", Frontiers in Robotics and AI 7 (2021): two sections of a nitinol wire with ten disks each. Turned so
that the first tendon of each section lies on +x; the damping is an assumption."""


def _franka() -> Tables:
    """Sections and tendons of `FRANKA_TDCR_V4`: the tendons of each section 40 degrees from those before."""
    lengths = (0.06, 0.0625, 0.064)
    ends = (0.06, 0.1225, 0.1865)
    mass = 0.05 / sum(lengths)
    sections = [
        {"length": one, "radius": 5e-4, "youngs_modulus": 50e9, "mass_per_length": round(mass, 6)} for one in lengths
    ]
    tendons = []
    for number, end in enumerate(ends):
        tendons += _tendons(_around(3, 0.0045, number * math.radians(40.0)), end)
    return {"section": sections, "tendon": tendons}


FRANKA_TDCR_V4: Tables = {
    **_franka(),
    "damping_ratio": 0.05,
    "gravity": (0.0, 0.0, 0.0),
    "yield_strain": 0.06,
}
"""Three-section arm of opencr-mujoco (github.com/ContinuumRoboticsLab/opencr-mujoco, ftdcr_v4; arXiv 2606.22397):
lengths, tendon radius, fitted modulus, lumped mass. The angles between the sections' tendons and the damping are
assumptions."""

PRESETS: dict[str, Tables] = {
    "paper": PAPER,
    "nitinol": NITINOL,
    "rucker-webster-2011": RUCKER_WEBSTER_2011,
    "till-2019": TILL_2019,
    "rao-2021": RAO_2021,
    "franka-tdcr-v4": FRANKA_TDCR_V4,
}
"""Tables of [rod] by name."""


@dataclass(frozen=True)
class PresetAbout:
    """A robot by name, for people: what it is, its source, and what is assumed or left out."""

    robot: str
    source: str
    assumed: str


ABOUT: dict[str, PresetAbout] = {
    "paper": PresetAbout(
        "steel wire of 0.5 m, four tendons at 20 mm; the default", "Danesh & Janabi-Sharifi 2024", "Poisson's ratio"
    ),
    "nitinol": PresetAbout(
        "one section of 0.2 m, three tendons at 10 mm", "Rao et al. 2021, its proximal section",
        "damping; disks spread along it",
    ),
    "rucker-webster-2011": PresetAbout(
        "spring steel, 0.242 m, four tendons at 8 mm", "Rucker & Webster 2011", "damping; density of bare steel"
    ),
    "till-2019": PresetAbout(
        "steel wire of 0.714 m, one elastic tendon", "Till, Aloi & Rucker 2019, their published program", "nothing"
    ),
    "rao-2021": PresetAbout(
        "two sections of 0.2 m with ten disks each, six tendons", "Rao et al. 2021", "damping; no gravity"
    ),
    "franka-tdcr-v4": PresetAbout(
        "three sections, nine tendons at 4.5 mm", "opencr-mujoco 2026",
        "damping; angles between the sections' tendons; no gravity",
    ),
}  # fmt: skip
"""What `tendond config presets` lists; the full references stand beside each preset above."""
