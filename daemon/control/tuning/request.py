"""A request to tune: checked like a configuration, then taken as what the values in use move to."""

import math
from dataclasses import astuple
from difflib import get_close_matches

from pydantic import ValidationError

from tendond.daemon.control.gains import law_rates
from tendond.daemon.control.laws.registry import select_law
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.tuning.keys import TunableKey
from tendond.daemon.control.tuning.tuning import Tuning, tuning_of
from tendond.daemon.errors import TuningError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.explain import explain
from tendond.schemas.messages import Mode


def retune(setup: CycleSetup, mode: Mode, tuning: Tuning, settings: dict[str, float]) -> tuple[Tuning, str]:
    """Return the tuning with other values wanted, and what was done, in words.

    Args:
        setup: setup of the cycle, of the configuration itself.
        mode: of the controller; while idle, values are taken at once.
        tuning: in use.
        settings: values by key of the configuration.

    Raises:
        TuningError: a key that is not tunable, or not now; or values that the configuration could not have.
    """
    keys = setup.tunable
    for name, value in settings.items():
        check_key(keys, name, value)
        if keys[name].rate is None and mode is not Mode.IDLE:
            remedy = "reset" if mode is Mode.FAULT else "stop"
            raise TuningError(f"{name} changes only while idle: {mode.value}; {remedy} first")
    wanted = {**tuning.wanted, **settings}
    config = with_values(setup.config, keys, wanted)
    present = {name: tuning.present.get(name, keys[name].configured) for name in wanted}
    if mode is Mode.IDLE:
        present |= settings
    parts = [_in_words(keys[name], present[name], value) for name, value in settings.items()]
    if any(keys[name].law for name in settings) and (remark := convergence_remark(setup.config, config)):
        parts.append(remark)
    return tuning_of(setup, present, wanted), "; ".join(parts)


def check_key(keys: dict[str, TunableKey], name: str, value: float) -> None:
    """Refuse a key that is not tunable, and a value that it cannot take.

    Raises:
        TuningError: says which, and what is allowed.
    """
    if name not in keys:
        raise TuningError(
            f"{name} is not tunable: {_suggestion(name, keys)}; change other keys in the configuration, and restart "
            "the controller"
        )
    key = keys[name]
    unit = f" [{key.unit}]" if key.unit else ""
    if not math.isfinite(value) or (key.rate is not None and value <= 0.0):
        raise TuningError(f"{name} = {value:g}: must be a number > 0{unit}")
    if key.lower_only and value > key.configured:
        raise TuningError(
            f"{name} = {value:g}: must be {key.configured:g}{unit}, the configuration's, or less; for more change the "
            "configuration, and restart the controller"
        )


def with_values(config: RigConfig, keys: dict[str, TunableKey], values: dict[str, float]) -> RigConfig:
    """Return the configuration with other values, checked as a whole.

    Raises:
        TuningError: it could not be a configuration.
    """
    tables = config.model_dump()
    for name, value in values.items():
        key = keys[name]
        table = tables["control"]["laws"].setdefault(key.law, {}) if key.law else tables[key.table]
        table[key.name] = value
    try:
        found = RigConfig.model_validate(tables)
    except ValidationError as error:
        raise TuningError("; ".join(explain(error, RigConfig))) from None
    select_law(found.control.law, found.control.laws)
    return found


def convergence_remark(configured: RigConfig, changed: RigConfig) -> str:
    """Say that a law is now faster than the laws for which the observer's gains keep a margin; empty if none is."""
    before, after = astuple(law_rates(configured)), astuple(law_rates(changed))
    if not any(new > old for new, old in zip(after, before, strict=True)):
        return ""
    return (
        "remark: faster than what the observer's gains keep a margin for: the arm may swing; put it into the "
        "configuration and restart the controller to have them made for it"
    )


def _suggestion(name: str, keys: dict[str, TunableKey]) -> str:
    matches = get_close_matches(name, keys, n=1)
    return f"did you mean '{matches[0]}'?" if matches else "'tendond rig get' lists those that are"


def _in_words(key: TunableKey, present: float, wanted: float) -> str:
    text = f"{key.path} = {wanted:g}"
    if present == wanted or key.rate is None:
        return text
    return f"{text}, from {present:g} within {abs(math.log(wanted) - math.log(present)) / math.log1p(key.rate):.1f} s"
