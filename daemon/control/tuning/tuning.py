"""Values in use of tuned keys, part of the cycle's state: each moves towards the one asked for at a bounded rate."""

import dataclasses
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from tendond.daemon.control.commissioning.probe_plan import probe_limits
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.tuning.keys import LAW_TABLES
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.rig import RigConfig


@dataclass(frozen=True)
class Tuning:
    """Tuned keys and what follows from them.

    Attributes:
        present: values in use, by key. wanted: values that they move to.
        rates: largest relative rates of change [1/s].
        config: the configuration with the sections in use; none where no section is tuned. Tables of laws are as in
            the file: references are planned, and the observer's gains made, from these.
        probe: limits of the probe with it.
    """

    present: dict[str, float]
    wanted: dict[str, float]
    rates: dict[str, float]
    config: RigConfig | None = None
    probe: LimitsSection | None = None

    def __len__(self) -> int:
        """Return the number of tuned keys."""
        return len(self.present)

    def to_snapshot(self) -> dict[str, Any]:
        """Return the data of it; the rest is made again from the configuration."""
        return {"present": self.present, "wanted": self.wanted}

    @classmethod
    def from_snapshot(cls, data: dict[str, Any], setup: CycleSetup) -> "Tuning":
        """Make the tuning that `to_snapshot` wrote."""
        return tuning_of(setup, data["present"], data["wanted"])

    def advance(self, setup: CycleSetup) -> "Tuning":
        """Return the tuning a cycle later: each value by at most a factor of 1 + rate h nearer to the one wanted."""
        if self.present == self.wanted:
            return self
        period = setup.config.loop.period
        present = {
            key: _nearer(value, self.wanted[key], self.rates[key] * period) for key, value in self.present.items()
        }
        return tuning_of(setup, present, self.wanted)

    def parameters_of(self, law: str, parameters: Any) -> Any:
        """Return a law's parameters with the values in use."""
        prefix = f"{LAW_TABLES}.{law}."
        values = {key.removeprefix(prefix): value for key, value in self.present.items() if key.startswith(prefix)}
        if not values:
            return parameters
        if isinstance(parameters, BaseModel):
            return parameters.model_copy(update=values)
        return dataclasses.replace(parameters, **values)

    def applied_to(self, setup: CycleSetup) -> CycleSetup:
        """Return the setup with the sections in use, for decision, limits and prediction."""
        if self.config is None or self.probe is None:
            return setup
        return dataclasses.replace(setup, config=self.config, probe_limits=self.probe)


UNTUNED = Tuning({}, {}, {})


def tuning_of(setup: CycleSetup, present: dict[str, float], wanted: dict[str, float]) -> Tuning:
    """Return the tuning with these values; keys that are at their configured value, and stay, are left out."""
    keys = setup.tunable
    kept = [key for key in wanted if not present[key] == wanted[key] == keys[key].configured]
    tuning = Tuning(
        {key: present[key] for key in kept},
        {key: wanted[key] for key in kept},
        {key: keys[key].rate or 0.0 for key in kept},
    )
    return _with_sections(setup, tuning)


def _with_sections(setup: CycleSetup, tuning: Tuning) -> Tuning:
    values: dict[str, dict[str, float]] = {}
    for key, value in tuning.present.items():
        if not key.startswith(LAW_TABLES):
            section, _, name = key.partition(".")
            values.setdefault(section, {})[name] = value
    if not values:
        return tuning
    sections = {name: getattr(setup.config, name).model_copy(update=changes) for name, changes in values.items()}
    config = setup.config.model_copy(update=sections)
    return dataclasses.replace(tuning, config=config, probe=probe_limits(config))


def _nearer(value: float, wanted: float, part: float) -> float:
    """Return `wanted`, or `value` changed by a factor of 1 + part towards it; both are positive."""
    return min(wanted, value * (1.0 + part)) if wanted > value else max(wanted, value / (1.0 + part))
