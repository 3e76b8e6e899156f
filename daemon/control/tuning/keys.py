"""Tunable keys of a configuration: those that its sections and the laws' parameters mark."""

from dataclasses import dataclass

from tendond.daemon.control.laws.registry import LAWS, select_law
from tendond.schemas.base import Schema
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.tunable import marks_of
from tendond.schemas.errors.keywords import keys_of

LAW_TABLES = "control.laws"


@dataclass(frozen=True)
class TunableKey:
    """A key that may change while the controller runs.

    Attributes:
        path: of the configuration, with dots. table, name: parts of it, before and after the last dot.
        configured: value of the configuration, in the key's unit.
        rate: largest relative rate of change while armed [1/s]; none: it changes only while idle.
        lower_only: no value above `configured` is accepted.
        allowed: allowed values in words. unit: SI; empty where the key does not say it.
    """

    path: str
    configured: float
    rate: float | None
    lower_only: bool
    allowed: str
    unit: str

    @property
    def table(self) -> str:
        """Table of the configuration that has it."""
        return self.path.rpartition(".")[0]

    @property
    def name(self) -> str:
        """Name within its table."""
        return self.path.rpartition(".")[2]

    @property
    def law(self) -> str:
        """Name of the law that it is a parameter of; empty for other keys."""
        return self.table.removeprefix(f"{LAW_TABLES}.") if self.table.startswith(f"{LAW_TABLES}.") else ""


def tunable_keys(config: RigConfig) -> dict[str, TunableKey]:
    """Return the tunable keys of a configuration by path; its own rates are those derived, where it names none.

    Raises:
        LawError: a law's parameters are wrong.
    """
    found: dict[str, TunableKey] = {}
    for section in RigConfig.model_fields:
        values = getattr(config, section)
        if isinstance(values, Schema):
            found |= _of(section, type(values), values)
    for name in LAWS:
        law, parameters = select_law(name, config.control.laws)
        found |= _of(f"{LAW_TABLES}.{name}", law.parameters, parameters)
    return found


def _of(table: str, model: type, values: object) -> dict[str, TunableKey]:
    if not (marks := marks_of(model)):
        return {}
    words = {key.name: key for key in keys_of(model)}
    return {
        f"{table}.{name}": TunableKey(
            f"{table}.{name}", float(getattr(values, name)), *mark, words[name].words, words[name].unit
        )
        for name, mark in marks.items()
    }
