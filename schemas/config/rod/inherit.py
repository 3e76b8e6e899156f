"""Keys of [rod] over those of a preset, and keys of [simulator.rod] over those of [rod]."""

from collections.abc import Mapping
from typing import Any

Tables = dict[str, Any]

SHORT_FORM = {
    "section": (
        "length", "radius", "youngs_modulus", "poisson_ratio", "density", "shear_damping", "bending_damping", "drag",
        "outer_radius",
    ),
    "tendon": ("tendon_positions", "tendon_stiffness"),
    "tip": ("tip_mass", "tip_inertia", "tip_offset"),
}  # fmt: skip
"""Table of the full form, and the keys of [rod] that are its short form for one uniform section."""

HEADINGS = {"section": "[[rod.section]]", "tendon": "[[rod.tendon]]", "tip": "[rod.tip]"}
"""Headings of these tables."""

ALTERNATIVES = (("damping_ratio", "bending_damping"),)
"""Keys of which one replaces the other."""


def over(base: Mapping[str, Any], own: Mapping[str, Any]) -> Tables:
    """Return `base` with the keys of `own` over it; a table of `own` replaces the short form of it in `base`."""
    kept = dict(base)
    for table, short in SHORT_FORM.items():
        if own.get(table):
            kept = {key: value for key, value in kept.items() if key not in short}
    for pair in ALTERNATIVES:
        for one, other in (pair, pair[::-1]):
            if own.get(one) is not None and other not in own:
                kept.pop(other, None)
    if "damping_ratio" not in own and damped_themselves(own.get("section")):
        kept.pop("damping_ratio", None)
    mount = own.get("base")
    if isinstance(mount, Mapping) and mount.get("down") is not None:
        kept.pop("gravity", None)
    return kept | dict(own)


def damped_themselves(sections: Any) -> bool:
    """Return whether there are sections, and each has a damping of its own: rod.damping_ratio has no effect then."""
    if not isinstance(sections, list | tuple) or not sections:
        return False
    return all(any(_value(one, key) is not None for key in ALTERNATIVES[0]) for one in sections)


def _value(table: Any, key: str) -> Any:
    return table.get(key) if isinstance(table, Mapping) else getattr(table, key, None)
