"""What is known of parameters beforehand: a value and its standard deviation, from the command line or a TOML file."""

import math
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tendond.daemon.errors import UsageError
from tendond.offline.identification.parameters import members, names

FORM = "give KEY=VALUE+-SIGMA in the unit of the key, for instance rod.density=6450+-100"


@dataclass(frozen=True)
class Prior:
    """A normal prior. value: its mean. sigma: its standard deviation; both in the parameter's unit."""

    value: float
    sigma: float


def parse_priors(options: Iterable[str]) -> dict[str, Prior]:
    """Parse `KEY=VALUE+-SIGMA`, or names of TOML files with `KEY = [VALUE, SIGMA]`, by parameter.

    A key is a parameter's name or that of the configuration; of a vector it is the prior of each component.

    Raises:
        UsageError: another form, an unknown key, a sigma that is not above zero, or a file that cannot be read.
    """
    found: dict[str, Prior] = {}
    for option in options:
        key, sign, text = option.partition("=")
        if sign:
            value, _, sigma = text.replace("±", "+-").partition("+-")
            found |= _prior(f"--prior {option}", key.strip(), (value, sigma))
        else:
            for name, pair in _read(Path(option)).items():
                found |= _prior(f"{option}: {name} = {pair}", name, pair)
    return found


def _read(path: Path) -> dict[str, Any]:
    """Return the keys of a file, those of its tables too."""
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise UsageError(f"--prior {path}: is neither a file of priors ({reason}) nor one: {FORM}") from None
    return {
        name: value
        for key, one in tables.items()
        for name, value in (one.items() if isinstance(one, dict) else ((key, one),))
    }


def _prior(where: str, key: str, pair: Any) -> dict[str, Prior]:
    """Return the priors of a key's parameters."""
    parts = members(key.rpartition(".")[2])
    if not parts:
        raise UsageError(f"{where}: '{key}' is no parameter: choose among {', '.join(names())}")
    try:
        value, sigma = (float(one) for one in pair)
    except (TypeError, ValueError):
        raise UsageError(f"{where}: is no prior: {FORM}") from None
    if not (math.isfinite(value) and math.isfinite(sigma) and sigma > 0.0):
        raise UsageError(f"{where}: the sigma must be finite and above 0, and the value finite: {FORM}")
    return dict.fromkeys(parts, Prior(value, sigma))
