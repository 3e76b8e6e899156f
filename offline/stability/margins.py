"""The margin of a configuration's loop: one property is changed at a time, until an eigenvalue leaves the circle."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from tendond import TendondError
from tendond.daemon.control.laws import LAWS, StatefulLaw, select_law
from tendond.daemon.control.laws.law import Gain
from tendond.offline.robustness.unlike import unlike
from tendond.offline.stability.cases import Case, Result, solve_loop
from tendond.schemas.config.rig import RigConfig, check_config

LATER = (1.0, 2.0, 3.0, 5.0)
STIFFER, SOFTER = (1.1, 1.2, 1.3, 1.5, 2.0), (0.9, 0.8, 0.7, 0.5)
LESS_DAMPED = (0.5, 0.25, 0.1, 0.03)
HIGHER, LOWER = (2.0, 4.0, 10.0), (0.5, 0.25, 0.1, 0.03)


@dataclass(frozen=True)
class Change:
    """A property in which the plant, the poses or the law differ from the configuration, in steps away from it.

    Attributes:
        name: for people. key: of `varied`. values: that are tried until a loop is unstable.
        steadies: whether it is tried on an unstable loop, until one is stable.
    """

    name: str
    key: str
    values: tuple[float, ...]
    steadies: bool = False


CHANGES = (
    Change("poses later by cycles", "delay", LATER),
    Change("E of the robot, factor up", "stiffness", STIFFER),
    Change("E of the robot, factor down", "stiffness", SOFTER),
    Change("damping of the robot, factor", "damping", LESS_DAMPED),
    Change("gains of the law, factor up", "gains", HIGHER),
    Change("gains of the law, factor down", "gains", LOWER, True),
)


@dataclass(frozen=True)
class Margin:
    """What a change comes to.

    Attributes:
        name: of the change. value: of it. result: of the loop.
    """

    name: str
    value: float
    result: Result


def margins(config: RigConfig, name: str, bend: float) -> Iterator[Margin]:
    """Yield the configuration's own loop, named "as configured", and the changes, each up to the first unstable loop.

    Args:
        config: of the rig. name: of it, for people. bend: of the model at the target [degrees].

    Raises:
        TendondError: the law has a state of its own, or the observer is a filter.
    """
    if isinstance(LAWS.get(config.control.law), StatefulLaw):
        raise TendondError(f"control.law: the state of {config.control.law} is not among the loop's: name another law")
    if config.observer.kind != "force":
        raise TendondError(
            "observer.kind: the map has fixed gains; `tendond study margin --observer kalman` has others"
        )
    case = Case(name, config.control.law, 1.0 / config.loop.period, _late(config), bend=bend)
    own = solve_loop(varied(config), case)
    yield Margin("as configured", 1.0, own)
    gains = has_gains(config)
    for change in CHANGES:
        if (change.key == "gains" and not gains) or not (own.stable or change.steadies):
            continue
        for value in change.values:
            # Poses on their way are the loop's, not the configuration's.
            changed = varied(config) if change.key == "delay" else varied(config, **{change.key: value})
            found = solve_loop(changed, _case_of(case, change.key, value))
            yield Margin(change.name, value, found)
            if found.stable is not own.stable:
                break


def own_loop(config: RigConfig, bend: float) -> Result:
    """Solve a configuration's own loop at a bend [degrees]; see `margins`."""
    return next(iter(margins(config, "own", bend))).result


def _late(config: RigConfig) -> int:
    return round(config.observer.delay / config.loop.period)


def _case_of(case: Case, key: str, value: float) -> Case:
    if key == "delay":
        return replace(case, delay=case.delay + int(value))
    if key == "stiffness":
        return replace(case, stiffness=value)
    return replace(case, damping=value) if key == "damping" else case


def has_gains(config: RigConfig) -> bool:
    """Return whether the law has parameters that are gains."""
    return bool(_gains_of(config))


def _gains_of(config: RigConfig) -> dict[str, float]:
    law, parameters = select_law(config.control.law, config.control.laws)
    bounds = Gain.__metadata__[0].metadata  # type: ignore[attr-defined]  # mypy does not know what Annotated keeps
    fields = law.parameters.model_fields.items()
    return {name: getattr(parameters, name) for name, field in fields if field.metadata == bounds}


def varied(config: RigConfig, *, stiffness: float = 1.0, damping: float = 1.0, gains: float = 1.0) -> RigConfig:
    """Return a configuration with both rods general, without what belongs to a rig, and with another plant or gains.

    Args:
        config: of the rig.
        stiffness, damping: factors on the plant's E and damping [-]. gains: factor on those of the law [-].
    """
    period, plant = config.loop.period, unlike(config.rod, stiffness, damping)
    values = config.model_dump(mode="json")
    kept = {key: values[key] for key in ("rod", "loop", "control", "observer", "limits", "faults")}
    kept["control"]["solver"] = "general"
    if gains != 1.0:
        laws = kept["control"]["laws"]
        laws[config.control.law] = laws.get(config.control.law, {}) | {
            name: gains * value for name, value in _gains_of(config).items()
        }
    kept["commissioning"] = {"rest": False, "probe": False}
    kept["simulator"] = {"period": period, "solver": "general", "rod": plant.model_dump(mode="json")}
    return check_config(kept, "margins")


def summary(found: list[Margin]) -> list[str]:
    """Say for each change up to where the loop is stable, or which gains steady it."""
    own, lines = found[0].result, []
    for change in CHANGES:
        some = [one for one in found if one.name == change.name]
        if not some:
            continue
        last = some[-1]
        if own.stable and last.result.stable:
            lines.append(f"{change.name}: stable to {last.value:g}, the last that was tried")
        elif own.stable:
            reach = f"stable to {some[-2].value:g}, " if len(some) > 1 else ""
            lines.append(f"{change.name}: {reach}unstable at {last.value:g}")
        elif last.result.stable:
            lines.append(f"{change.name}: stable from {last.value:g} down")
        else:
            lines.append(
                f"{change.name}: unstable down to {last.value:g}: no gains of this law that were tried steady it"
            )
    return lines
