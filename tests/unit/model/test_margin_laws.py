"""Rates of the laws, which the margin of the observer's gains is kept for."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest

from tendond.daemon.control import gains as feedback
from tendond.daemon.control import selection as selection_module
from tendond.daemon.control.gains import law_rates
from tendond.daemon.control.laws import BENDING_PLANE, LAWS, Convergence, StatelessLaw, backstepping
from tendond.daemon.errors import LawError
from tendond.model.estimation.poles import LawRates
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig, parse_config


def test_the_laws_rates_follow_from_their_parameters() -> None:
    rates = law_rates(parse_config("[control.laws.backstepping]\nalpha1 = 100.0\nalpha2 = 40.0\n", "fast"))
    assert rates.velocity == pytest.approx(4001.0 / 140.0)
    assert law_rates(RigConfig()).velocity == pytest.approx(12.4, rel=0.01)


def law_with(name: str, convergence: Convergence | None) -> StatelessLaw[Any, Any]:
    return StatelessLaw(
        name, backstepping.Parameters, backstepping.decide, BENDING_PLANE,
        rates=None if convergence is None else lambda parameters: convergence,
    )  # fmt: skip


class Older:
    """A law of a package from before laws said their rate."""

    name, parameters, state, task_space = "older", backstepping.Parameters, type(None), BENDING_PLANE

    def start(self, parameters: Any) -> None:
        return None

    def decide(self, parameters: Any, observation: Any, state: Any) -> Any:
        return backstepping.decide(parameters, observation)


@pytest.fixture
def registered() -> Iterator[None]:
    """Laws of packages: two that say their rate, one that says none, and one that cannot."""
    older: Any = Older()
    LAWS.register(older)
    LAWS.register(law_with("swift", Convergence(40.0)))
    LAWS.register(law_with("swift_ahead", Convergence(50.0, 200.0)))
    LAWS.register(law_with("silent", None))
    yield
    LAWS.forget()


@pytest.mark.usefixtures("registered")
def test_the_margin_is_that_for_the_rate_that_a_packages_law_says() -> None:
    swift, ahead = (parse_config(f'[control]\nlaw = "{name}"\n', name) for name in ("swift", "swift_ahead"))
    listed, silent = (parse_config(text, "law") for text in ("[control.laws.swift]\n", '[control]\nlaw = "silent"\n'))
    assert law_rates(swift) == law_rates(listed) == replace(law_rates(RigConfig()), velocity=40.0)
    assert law_rates(ahead) == replace(law_rates(RigConfig()), position=50.0, smoothing=200.0)
    assert law_rates(silent) == law_rates(RigConfig())
    assert law_rates(parse_config('[control]\nlaw = "older"\n', "older")) == law_rates(RigConfig())


@pytest.mark.usefixtures("registered")
def test_a_law_with_which_the_gains_would_be_lower_is_not_selected_while_running(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    config, rod = RigConfig(), rod_from_section(RigConfig().rod, 0.01)
    selection = selection_module.Selection.from_config(config, rod)
    assert selection.with_law(config, rod, "swift").law_name == "swift"  # as fast as it is, the gains stay
    assert selection.with_law(config, rod, "silent").law_name == "silent"

    def lowered_for_swift(rod: Any, period: float, alpha: float, wanted: Any, rates: LawRates, *rest: Any) -> Any:
        return replace(wanted, integral=1.0 if rates.velocity == 40.0 else 2.0)

    monkeypatch.setattr(feedback, "_admitted", lowered_for_swift)
    with pytest.raises(LawError, match=r"swift is faster than .* add \[control\.laws\.swift\] to the configuration"):
        selection.with_law(config, rod, "swift")
    listed = parse_config("[control.laws.swift]\n", "law")
    assert selection.with_law(listed, rod, "swift").law_name == "swift"
