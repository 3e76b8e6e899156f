"""Robots of two and three sections for tests, unlike the presets; each is made once."""

from functools import cache
from typing import Any

from tendond.daemon.control.pose.rests import PoseRests
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import RigConfig, check_config

WIRE = {"length": 0.15, "radius": 6e-4, "youngs_modulus": 60e9, "mass_per_length": 0.02}
TWO: dict[str, Any] = {
    "section": [WIRE, {**WIRE, "length": 0.11, "radius": 5e-4}],
    "tendon": [
        *({"position": place, "end": 0.15} for place in ((0.009, 0.0), (-0.0045, 0.0078), (-0.0045, -0.0078))),
        *({"position": place, "end": 0.26} for place in ((0.0, 0.009), (0.0, -0.009), (0.009, 0.0), (-0.009, 0.0))),
    ],
    "damping_ratio": 0.1,
}
"""Two sections that hang in gravity, with three and four tendons."""

THREE: dict[str, Any] = {"preset": "franka-tdcr-v4"}


def config_of(rod: dict[str, Any], reference: dict[str, Any], **more: Any) -> RigConfig:
    """Return the configuration of a robot with the law 'sensitivity'."""
    values = {
        "rod": rod,
        "control": {"law": "sensitivity"},
        "limits": {"tension_max": 20.0},
        "reference": reference,
        **more,
    }
    return check_config(values, "test")


@cache
def rests(which: str) -> PoseRests:
    """Return the rests of the robot 'two' or 'three'."""
    config = config_of(TWO if which == "two" else THREE, {})
    return PoseRests(model_rod(config), 1.0, 20.0, "least_tension")
