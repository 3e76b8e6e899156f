"""The loop's eigenvalues are those of the loop that runs."""

import numpy as np
import pytest

from tendond.offline.stability.cases import Case, looped, map_cases


@pytest.mark.parametrize(("robot", "size", "stable"), [("rucker-webster-2011", 2e-2, True), ("rao-2021", 1e-3, False)])
def test_the_linear_loop_moves_as_the_loop_that_runs(robot: str, size: float, stable: bool) -> None:
    loop, _ = looped(Case(robot, "backstepping", bend=30.0))
    found = loop.linear()
    assert (found.radius < 1.001) is stable
    assert found.missing < 1e-6
    aside = np.zeros(len(loop.state))
    bend = loop.places[9]  # of the plant, as if it had been pushed
    aside[bend] = size * loop.scale[bend]
    x, predicted = loop.state + aside, aside
    for _ in range(6):
        x, predicted = loop.cycle(x), found.matrix @ predicted
    moved = (x - loop.state) / loop.scale
    assert moved == pytest.approx(predicted / loop.scale, abs=0.05 * float(np.max(np.abs(moved))))


def test_the_default_law_of_an_arm_of_sections_is_stable_and_brings_it_back() -> None:
    """Its tendons are at their least tension, where the map has an edge: what runs is tried as well."""
    loop, config = looped(Case("rao-2021", bend=30.0))
    assert config.control.law == "sensitivity"
    found = loop.linear()
    assert found.radius < 1.001
    assert found.missing < 1e-6
    strains = slice(loop.places[9], loop.places[10])  # of the plant; its fastest modes swing on at their own damping
    rest = loop.state[strains].copy()
    loop.state[loop.places[9]] += 2e-2 * loop.scale[loop.places[9]]
    loop.settle(450)
    assert np.max(np.abs(loop.state[strains] - rest) / loop.scale[strains]) < 2e-4


def test_the_map_has_every_rate_and_bend_of_each_robot() -> None:
    cases = map_cases(("nitinol", "paper"), "backstepping")
    assert len(cases) == len(set(cases)) == 2 * (4 * 3 + 3 * 6)
    assert len(map_cases(("nitinol",), "backstepping", short=True)) == 1
