"""The grid of rests against the rod's own statics."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rest_grid import configured_rests, largest_weight, rest_family
from tendond.daemon.control.commissioning.rests import Tolerances
from tendond.model.errors import ConvergenceError
from tendond.model.rod.rod import Rod
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import parse_config
from tests.unit.commissioning.rest.rests import rest

Array = NDArray[np.float64]


def test_the_largest_weight_is_a_part_of_the_rods_own_mass_and_stiffness() -> None:
    config = parse_config("", "test")
    parameters = rod_from_section(config.rod, 0.01).parameters
    mass = parameters.mass_per_length * 0.5
    stiff = 190e9 * math.pi * 1e-3**4 / 4.0 / (0.25 * 9.81)
    assert largest_weight(parameters) == pytest.approx(1.2 * (mass + stiff), rel=1e-3)
    assert largest_weight(replace(parameters, gravity=(0.0, 0.0, 0.0))) == pytest.approx(1.2 * mass)


@pytest.fixture
def fresh() -> None:
    """Families are kept: compute them anew."""
    rest_family.cache_clear()


@pytest.mark.usefixtures("fresh")
def test_a_configured_family_spans_weights_and_stiffnesses_from_the_rods_own_statics() -> None:
    config = parse_config(
        "[commissioning]\nweight_max = 0.031\nstiffness = 0.25\ntilt = 0.02\noffset = 0.01\norientation = 0.3\n", "test"
    )
    rod = rod_from_section(config.rod, 0.01)
    found = configured_rests(config, rod.parameters)
    assert found is not None
    assert (found.length, found.tolerances) == (0.5, Tolerances(0.02, 0.005, 0.3))
    assert found.weights.min() == 0.0
    assert found.weights.max() == pytest.approx(0.031)
    assert (found.stiffnesses.min(), found.stiffnesses.max()) == pytest.approx((0.75, 1.25))
    for stiffness in (0.75, 1.25):
        for weight in (0.0, 0.031):
            index = int(np.argmin(np.abs(found.stiffnesses - stiffness) + np.abs(found.weights - weight)))
            position, rotation = rest(stiffness, weight)
            assert found.positions[index] == pytest.approx(position, abs=1e-6)
            assert found.rotations[index] == pytest.approx(rotation, abs=1e-6)
    places = zip(found.stiffnesses.tolist(), found.weights.tolist(), found.positions, strict=True)
    for stiffness, weight, position in list(places)[::37]:  # linear between the grid's equilibria
        assert position == pytest.approx(rest(stiffness, weight)[0], abs=2e-4)
    turns = found.rotations @ found.rotations.transpose(0, 2, 1)
    assert np.abs(turns - np.eye(3)).max() < 1e-12
    off = parse_config("[commissioning]\nrest = false\n", "test")
    assert configured_rests(off, rod.parameters) is None


@pytest.mark.usefixtures("fresh")
def test_a_family_is_of_the_configured_scheme_and_bears_the_robots_largest_weight() -> None:
    config = parse_config('[rod]\nspace = "euler"\nnodes = 23\n', "test")
    rod = rod_from_section(config.rod, 0.01)
    found = configured_rests(config, rod.parameters)
    assert found is not None
    assert found.weights.max() == pytest.approx(largest_weight(rod.parameters))
    slack = np.zeros(4)
    for index in (int(np.argmin(found.weights + np.abs(found.stiffnesses - wanted))) for wanted in (0.0, 9.0)):
        section = config.rod.model_copy(
            update={"youngs_modulus": float(found.stiffnesses[index]) * config.rod.youngs_modulus}
        )
        one = rod_from_section(section, 0.01)
        assert found.positions[index] == pytest.approx(one.tip(one.solve_static(slack)).position, abs=1e-9)


@pytest.mark.usefixtures("fresh")
def test_a_family_ends_where_a_weight_has_no_solution_and_there_is_none_without_a_rest(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config = parse_config("[commissioning]\nweight_max = 0.032\n", "test")
    parameters = rod_from_section(config.rod, 0.01).parameters
    solve = Rod.solve_static

    def within(weight_max: float) -> None:
        def limited(self: Rod, tensions: Array, **loads: Any) -> Any:
            if np.linalg.norm(loads["tip_force"]) > weight_max * 9.81:
                raise ConvergenceError("no equilibrium", 0.0, 1.0, 60)
            return solve(self, tensions, **loads)

        monkeypatch.setattr(Rod, "solve_static", limited)

    within(0.017)  # in steps of 2 g
    found = configured_rests(config, parameters)
    assert found is not None
    assert found.weights.max() == pytest.approx(0.016)
    rest_family.cache_clear()
    within(-1.0)
    with pytest.raises(ConvergenceError):
        configured_rests(config, parameters)


@pytest.mark.usefixtures("fresh")
def test_a_rod_without_gravity_has_one_rest() -> None:
    config = parse_config("[rod]\ngravity = [0.0, 0.0, 0.0]\n[commissioning]\nweight_max = 0.017\n", "test")
    found = configured_rests(config, rod_from_section(config.rod, 0.01).parameters)
    assert found is not None
    assert (found.weights.tolist(), found.stiffnesses.tolist()) == ([0.0], [1.0])
    assert found.positions == pytest.approx(np.array([[0.0, 0.0, 0.5]]))
