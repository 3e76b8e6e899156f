"""The margins of a rig's own loop: the first change that unsettles it, or the gains that steady it."""

from collections.abc import Sequence

import pytest

from tendond import TendondError
from tendond.offline.config_check import remarks
from tendond.offline.stability.cases import Case, Result
from tendond.offline.stability.margins import CHANGES, Margin, has_gains, margins, own_loop, summary, varied
from tendond.schemas.config.rig import RigConfig, check_config


def rig(law: str, robot: str = "rao-2021", **more: object) -> RigConfig:
    return check_config({"rod": {"preset": robot}, "control": {"law": law}, **more}, "test")


def result(radius: float) -> Result:
    return Result(Case("own"), "backstepping", 1.0, radius, 0.0, 0.0, 0.0)


def found(name: str, radii: Sequence[float], own: float = 0.99) -> list[Margin]:
    change = next(one for one in CHANGES if one.name == name)
    some = [Margin(name, value, result(one)) for value, one in zip(change.values, radii, strict=False)]
    return [Margin("as configured", 1.0, result(own)), *some]


def test_a_summary_names_the_last_stable_value_and_the_first_unstable_one() -> None:
    late = "poses later by cycles"
    assert summary(found(late, [0.99, 0.99, 1.2])) == [f"{late}: stable to 2, unstable at 3"]
    assert summary(found(late, [1.2])) == [f"{late}: unstable at 1"]
    assert summary(found(late, [0.9] * 4)) == [f"{late}: stable to 5, the last that was tried"]


def test_of_an_unstable_loop_it_names_the_gains_that_steady_it() -> None:
    lower = "gains of the law, factor down"
    assert summary(found(lower, [1.1, 0.99], own=1.3)) == [f"{lower}: stable from 0.25 down"]
    assert "no gains of this law" in summary(found(lower, [1.1] * 4, own=1.3))[0]


def test_changes_reach_the_plant_and_the_gains_alone() -> None:
    config = rig("backstepping")
    softer, lower = varied(config, stiffness=0.5, damping=0.1), varied(config, gains=0.5)
    assert config.rod == softer.rod
    scale = softer.simulator.rod.scale
    assert scale is not None
    assert (scale.stiffness, scale.damping) == (0.5, 0.1)
    assert lower.control.laws["backstepping"] == {"alpha1": 750.0, "alpha2": 6.25}
    assert lower.simulator.rod == varied(config).simulator.rod
    assert has_gains(config)
    assert not has_gains(rig("sensitivity"))


def test_an_unstable_loop_is_unstable_with_small_gains_too_and_config_check_says_so() -> None:
    config = rig("backstepping")
    first = own_loop(config, 60.0)
    assert first.radius > 1.1
    assert not first.stable
    assert own_loop(varied(config, gains=0.1), 60.0).radius > 1.1
    said = "\n".join(remarks(config, None))
    assert f"motions grow by a factor of {first.radius:.3g} in each cycle" in said


def test_what_the_map_does_not_have_is_said_in_a_line() -> None:
    with pytest.raises(TendondError, match="the state of mpc"):
        next(iter(margins(rig("mpc"), "own", 60.0)))
    with pytest.raises(TendondError, match=r"observer\.kind"):
        next(iter(margins(rig("backstepping", "nitinol", observer={"kind": "kalman"}), "own", 60.0)))
