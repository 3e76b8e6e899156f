"""Known weights on the tip, from the command line or a log's metadata."""

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from tendond.daemon.errors import UsageError
from tendond.offline.identification.recordings.recording import DataError
from tendond.offline.logs.arrays import Arrays
from tendond.schemas.mistaken_units import unit_hint

WEIGHT_NOTE = "weight"
"""Name in a log's metadata of the known weight on its tip [kg]."""

LARGEST = 10.0
"""Largest weight that is taken for one [kg]."""


def weight_of(arrays: Arrays, path: Path, weights: Mapping[str, float]) -> float:
    for name in (str(path), path.name):
        if name in weights:
            return weights[name]
    text = arrays.metadata.get(WEIGHT_NOTE)
    if text is None:
        return 0.0
    try:
        return parse_weight(text)
    except ValueError:
        raise DataError(
            f"{path}: its metadata '{WEIGHT_NOTE}' is '{text}', which is not a mass in kg: give --weight"
        ) from None


def parse_weight(text: str) -> float:
    """Parse a weight [kg].

    Raises:
        ValueError: not a number from 0 to 10.
    """
    value = float(text)
    if not 0.0 <= value <= LARGEST:
        raise ValueError
    return value


def parse_weights(options: list[str]) -> dict[str, float]:
    """Parse options `--weight LOG=KG`, by log.

    Raises:
        UsageError: an option of another form.
    """
    weights = {}
    for option in options:
        name, sign, text = option.rpartition("=")
        hint = ""
        try:
            weights[name] = parse_weight(text)
        except ValueError:
            sign = ""
            with suppress(ValueError):
                hint = unit_hint(float(text), LARGEST, "kg")
        if not sign or not name:
            raise UsageError(
                f"--weight {option}: give LOG=KG with 0 to 10 kg, for instance --weight loaded.mcap=0.05{hint}"
            )
    return weights
