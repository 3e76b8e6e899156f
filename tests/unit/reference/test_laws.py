"""The laws are the paper's formulas, and their parameters are checked."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.laws import LAWS, SPACE, Law, backstepping, select_law, sliding_mode
from tendond.daemon.control.laws.law import Decision, PlanarObservation, SpatialObservation
from tendond.daemon.errors import LawError
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

RNG = np.random.default_rng(7)

OF_A_CYCLE = [name for name in LAWS if name != "mpc"]
"""Laws that look one cycle ahead; the other's tests are in tests/unit/control/predictive."""


def observation() -> PlanarObservation:
    """Random but definite: nothing is zero by luck."""
    return PlanarObservation(
        position=RNG.normal(size=3),
        velocity=RNG.normal(size=3),
        acceleration=RNG.normal(size=3),
        input_gain=20.0 * RNG.normal(size=(3, 4)),
        velocity_jacobian=None,
        tension=RNG.uniform(1.0, 10.0, size=4),
        target=RNG.normal(size=3),
        target_velocity=RNG.normal(size=3),
        target_acceleration=RNG.normal(size=3),
        axes=(0, 2),
        agonist=0,
        antagonist=None,
        input_gain_min=1.0,
        pair_tension=0.0,
        period=0.01,
    )


def decided(name: str, o: PlanarObservation, tables: dict[str, dict[str, float]] | None = None) -> Decision:
    """Decide by a law of either task space for the same tip; in space without a prediction."""
    law, parameters = select_law(name, tables or {})
    in_space = SpatialObservation(o.position, o.velocity, o.target, o.target_velocity, o.tension, o.period, None)
    return law.decide(parameters, in_space if law.task_space is SPACE else o, law.start(parameters))


def as_printed(o: PlanarObservation, wanted: np.ndarray) -> float:
    """U = b^+ (-a_c + wanted), with a_c = acceleration - b U_applied and b^+ = b'/(b'b), in the plane."""
    b = o.input_gain[[0, 2], 0]
    a_c = o.acceleration[[0, 2]] - b * o.tension[0]
    return float(b @ (wanted - a_c) / (b @ b))


def test_backstepping_is_equation_back8() -> None:
    o, p = observation(), backstepping.Parameters(alpha1=9.0, alpha2=4.0)
    e, de = (o.target - o.position)[[0, 2]], (o.target_velocity - o.velocity)[[0, 2]]
    kp, kd = 1 + 9.0 * 4.0, 9.0 + 4.0
    expected = as_printed(o, o.target_acceleration[[0, 2]] + kd * de + kp * e)
    assert backstepping.decide(p, o).tension[0] == pytest.approx(expected, rel=1e-12)


def test_sliding_mode_is_equation_sdot3() -> None:
    o, p = observation(), sliding_mode.Parameters(c=9.0, k=4.0, epsilon=0.3)
    e, de = (o.target - o.position)[[0, 2]], (o.target_velocity - o.velocity)[[0, 2]]
    surface = de + 9.0 * e
    expected = as_printed(o, 9.0 * de + o.target_acceleration[[0, 2]] + 0.3 * np.sign(surface) + 4.0 * surface)
    assert sliding_mode.decide(p, o).tension[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", OF_A_CYCLE)
def test_a_law_holds_the_tension_when_nothing_is_missing(name: str) -> None:
    zero = np.zeros(3)
    o = dataclasses.replace(
        observation(), acceleration=zero, velocity=zero, target_velocity=zero, target_acceleration=zero
    )
    o = dataclasses.replace(o, target=o.position)
    assert decided(name, o).tension[0] == pytest.approx(o.tension[0], rel=1e-12)


@pytest.mark.parametrize("name", ["backstepping", "sliding_mode"])
@pytest.mark.parametrize("size", [0.0, 0.1, 10.0, 1000.0])
def test_a_law_takes_no_more_than_all_of_a_velocity_error_away_in_a_cycle(name: str, size: float) -> None:
    """Go from the straight rod, b_c = 0, to one bent so much that b_c^+ takes less."""
    jacobian = np.array([0.07, 0.0, 0.0])
    gain = np.zeros((3, 4))
    gain[0, 0] = size
    zero = np.zeros(3)
    o = dataclasses.replace(
        observation(), input_gain=gain, velocity_jacobian=jacobian, acceleration=zero, target_acceleration=zero,
        target_velocity=zero, velocity=np.array([0.3, 0.0, 0.0]),
    )  # fmt: skip
    o = dataclasses.replace(o, target=o.position)
    after = o.velocity + jacobian * (decided(name, o, {"sliding_mode": {"epsilon": 0.0}}).tension[0] - o.tension[0])
    taken = 1.0 - after[0] / o.velocity[0]
    rate = {"backstepping": 1512.5, "sliding_mode": 2112.0}[name]
    assert taken == pytest.approx(min(1.0, rate * 0.07 / size) if size else 1.0, rel=1e-4)


@pytest.mark.parametrize("name", OF_A_CYCLE)
def test_a_straight_rod_does_not_make_the_tension_infinite(name: str) -> None:
    o = dataclasses.replace(observation(), input_gain=np.zeros((3, 4)))
    assert np.all(np.isfinite(decided(name, o).tension))


def test_the_antagonist_pulls_when_the_net_tension_is_negative() -> None:
    o = dataclasses.replace(observation(), antagonist=2)
    wanted = backstepping.decide(backstepping.Parameters(), o)
    assert isinstance(wanted.terms, backstepping.Terms)
    net = wanted.terms.net_tension
    assert wanted.tension[0] - wanted.tension[2] == pytest.approx(net)
    assert min(wanted.tension) >= 0.0


def test_a_pair_keeps_its_min_tension_and_its_difference() -> None:
    o = dataclasses.replace(observation(), antagonist=2, pair_tension=1.5)
    wanted = backstepping.decide(backstepping.Parameters(), o)
    assert isinstance(wanted.terms, backstepping.Terms)
    assert wanted.tension[0] - wanted.tension[2] == pytest.approx(wanted.terms.net_tension)
    assert min(wanted.tension[[0, 2]]) == pytest.approx(1.5)
    assert wanted.tension[1] == wanted.tension[3] == 0.0


def test_an_unknown_law_and_bad_parameters_are_refused_by_key() -> None:
    with pytest.raises(LawError, match=r"control\.law: no law is called 'pid'; choose one of backstepping,"):
        select_law("pid", {})
    with pytest.raises(LawError, match=r"control\.laws\.backstepping\.alpha3: unknown key; did you mean 'alpha"):
        select_law("backstepping", {"backstepping": {"alpha3": 1.0}})
    with pytest.raises(LawError, match=r"control\.laws\.sliding_mode\.c = -1"):
        select_law("backstepping", {"sliding_mode": {"c": -1.0}})


def test_the_law_in_the_documentation_works_as_it_stands(request: pytest.FixtureRequest) -> None:
    text = (Path(__file__).parents[3] / "docs" / "control.md").read_text(encoding="utf-8")
    code = re.search(r"This is a complete one:\n\n```python\n(.*?)```", text, re.DOTALL)
    assert code is not None
    module: dict[str, Any] = {"__name__": __name__}
    exec(code[1], module)
    law: Law = module["LAW"]
    LAWS.register(law)
    request.addfinalizer(LAWS.forget)
    config = parse_config(f'[control]\nlaw = "{law.name}"\n', "test")
    records = list(closed_loop(config, 250, {5: ControlAction.ARM}))
    assert records[-1].mode is Mode.TRACKING
    assert records[-1].measured is not None
    assert records[-1].measured[0] == pytest.approx(0.34, abs=1e-3)
