"""A rod refuses what it cannot take, and says what, how much and what is allowed."""

from typing import Any

import numpy as np
import pytest

from tendond.model import ParameterError, Rod, RodParameters
from tests.unit.rod.rods import PAPER


@pytest.mark.parametrize(
    ("parameter", "value", "message"),
    [
        ("length", 0.0, r"length = 0\.0 must be above 0"),
        ("radius", -1e-3, r"radius = -0\.001 must be above 0"),
        ("youngs_modulus", float("nan"), "youngs_modulus is not finite"),
        ("density", float("inf"), "density is not finite"),
        ("tendon_stiffness", 0.0, r"tendon_stiffness = 0\.0 must be above 0"),
        ("poisson_ratio", 0.6, r"poisson_ratio = 0\.6 must lie in \(-1, 0\.5\]"),
        ("bending_damping", (0.0, -0.008, 0.0), r"bending_damping = \(0\.0, -0\.008, 0\.0\) must not be negative"),
        ("drag", (0.1, 0.1, float("nan")), "drag is not finite"),
        ("tendon_positions", (), "tendon_positions is empty"),
    ],
)
def test_a_bad_parameter_is_named(parameter: str, value: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        RodParameters(**{parameter: value})


@pytest.mark.parametrize(
    ("argument", "value", "message"),
    [
        ("space", "rk5", r"space scheme 'rk5' is unknown: choose one of euler, rk4"),
        ("nodes", 1, "nodes = 1 must be 2 or more"),
        ("time_step", 0.0, r"time_step = 0\.0 must be above 0 s"),
        ("time_step", float("nan"), "time_step = nan must be above 0 s"),
        ("alpha", -0.6, r"alpha = -0\.6 must lie in \[-0\.5, 0\]"),
    ],
)
def test_a_bad_discretisation_is_named(argument: str, value: Any, message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        Rod(PAPER, **{argument: value})


@pytest.mark.parametrize(
    ("loads", "message"),
    [
        ({"tensions": [1.0, 0.0, 0.0]}, r"tendon commands has shape \(3,\), must be \(4,\)"),
        ({"tensions": [1.0, -0.1, 0.0, 0.0]}, r"tensions = \[1\.0, -0\.1, 0\.0, 0\.0\] must not be negative"),
        ({"tensions": [1.0, float("nan"), 0.0, 0.0]}, r"tendon commands = \[1\.0, nan, 0\.0, 0\.0\] must be finite"),
        ({"displacements": [float("inf")] * 4}, r"tendon commands = \[inf, inf, inf, inf\] must be finite"),
        ({"tensions": np.zeros(4), "displacements": np.zeros(4)}, "give tensions or displacements, not both"),
        ({"tip_force": (0.0, 1.0)}, r"tip_force has shape \(2,\), must be \(3,\)"),
        ({"tip_moment": (0.0, 0.0, float("nan"))}, r"tip_moment = \[0\.0, 0\.0, nan\] must be finite"),
        ({"distributed_force": 1.0}, r"distributed_force has shape \(\), must be \(3,\)"),
        (
            {"distributed_moment": (float("-inf"), 0.0, 0.0)},
            r"distributed_moment = \[-inf, 0\.0, 0\.0\] must be finite",
        ),
    ],
)
def test_a_bad_load_is_named_in_statics_and_in_motion(loads: dict[str, Any], message: str) -> None:
    rod = Rod(PAPER)
    with pytest.raises(ParameterError, match=message):
        rod.solve_static(**loads)
    state = rod.solve_static()
    with pytest.raises(ParameterError, match=message):
        rod.step(state, **loads)
