"""Configuration of a rig: one TOML file, every key with its unit and range; SI throughout."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from pydantic import Field, ValidationError, model_validator

from tendond import TendondError
from tendond.schemas.base import Schema, is_empty
from tendond.schemas.config.commissioning import CommissioningSection, PretensionSection
from tendond.schemas.config.control import (
    ControlSection,
    FaultsSection,
    LimitsSection,
    LoopSection,
)
from tendond.schemas.config.drives import DrivesSection, drive_objections, with_drive_limits
from tendond.schemas.config.given import by_default
from tendond.schemas.config.machine import BusSection, LogSection, RigSection
from tendond.schemas.config.migration.version import KEY, version_objection, without_version
from tendond.schemas.config.mocap import MocapSection
from tendond.schemas.config.observer import ObserverSection
from tendond.schemas.config.rates import servo_objections, with_own_rates, with_servo_limits
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.renamed import with_new_names
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.inherit import over
from tendond.schemas.config.rod.swing import swings
from tendond.schemas.config.safety.section import SafetySection
from tendond.schemas.config.sensors.section import SensorSection, sensor_objections
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.config.simulator import SimulatorSection
from tendond.schemas.config.teleop import TeleopSection
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.errors.explain import Objection, in_file, objections
from tendond.schemas.errors.keywords import Path
from tendond.schemas.errors.toml_lines import key_lines, line_of, not_toml


class ConfigError(TendondError):
    """A configuration cannot be used: file, key, value and what is allowed, one line each.

    Attributes:
        objections: the same in parts; may be empty.
    """

    def __init__(self, text: str, objections: Sequence[Objection] = ()) -> None:
        self.objections = tuple(objections)
        super().__init__(text)


class RigConfig(Schema):
    """Configuration of a rig, for the controller, the drivers and the simulator."""

    rig: RigSection = RigSection()
    bus: BusSection = BusSection()
    loop: LoopSection = LoopSection()
    rod: RodSection = RodSection()
    control: ControlSection = ControlSection()
    observer: ObserverSection = ObserverSection()
    reference: ReferenceSection = ReferenceSection()
    limits: LimitsSection = LimitsSection()
    pretension: PretensionSection = PretensionSection()
    faults: FaultsSection = FaultsSection()
    commissioning: CommissioningSection = CommissioningSection()
    simulator: SimulatorSection = SimulatorSection()
    log: LogSection = LogSection()
    vicon: ViconSection | None = None
    mocap: MocapSection | None = Field(None, exclude_if=lambda value: value is None)
    servo: ServoSection | None = None
    drives: DrivesSection | None = Field(None, exclude_if=lambda value: value is None)
    sensors: tuple[SensorSection, ...] = Field((), max_length=16, exclude_if=is_empty)
    teleop: TeleopSection = Field(TeleopSection(), exclude_if=lambda value: value == TeleopSection())
    safety: SafetySection | None = Field(None, exclude_if=lambda value: value is None)

    @property
    def cameras(self) -> ViconSection | None:
        """Section of the cameras that measure the tip: [mocap], or [vicon], its older name for Tracker alone."""
        return self.mocap or self.vicon

    def with_own_rates(self) -> "RigConfig":
        """Return the configuration with derived rates in [limits] where none are given."""
        limits = with_own_rates(self.limits, self.rod, self.observer.lag, self.loop.period)
        return self if limits is self.limits else self.model_copy(update={"limits": limits})

    @model_validator(mode="before")
    @classmethod
    def _inherit(cls, data: Any) -> Any:
        """Give [simulator.rod] the values of [rod] where it has none of its own."""
        if not isinstance(data, Mapping) or not isinstance(simulator := data.get("simulator", {}), Mapping):
            return data
        own = simulator.get("rod", {})
        try:
            rod = RodSection.model_validate(data.get("rod", {}))
        except ValidationError:
            return data  # is said once, for [rod]
        if not isinstance(own, Mapping) or own.get("preset", rod.preset) != rod.preset:
            return data
        return {**data, "simulator": {**simulator, "rod": over(rod.model_dump(), own)}}

    @model_validator(mode="after")
    def _consistent(self) -> "RigConfig":
        self._suit_the_robot()
        if self.servo is not None:
            own = self.with_own_rates().limits
            if self.drives is None:
                limits = with_servo_limits(self.limits, own, self.servo)
            else:
                limits = with_drive_limits(self.limits, own, self.drives, self.servo)
            object.__setattr__(self, "limits", limits)  # frozen for everyone else
        wrong = [*self._tendon_objections(), *self._servo_objections(), *self._safety_objections()]
        if self.vicon is not None and self.mocap is not None:
            wrong.append(
                "[vicon] and [mocap] both name the cameras: keep one; [vicon] is [mocap] with system = 'vicon'"
            )
        if wrong := [
            *wrong,
            *sensor_objections(self.sensors, self.rod.backbone_length, len(self.rod.tendon_positions)),
        ]:
            raise ValueError("\n".join(wrong))
        return self

    def _suit_the_robot(self) -> None:
        """Give a robot that swings the law for it where none is named.

        It is then as if it had been named: a record of the configuration says it.
        """
        control = self.control
        if "law" in control.model_fields_set or control.rules == 1 or not swings(self.rod, self.loop.period):
            return
        if control.feedback == "direct" or control.solver == "shooting":
            return
        found = {"law": "sensitivity", "solver": "general"}
        object.__setattr__(self, "control", control.model_copy(update=found))  # frozen for everyone else

    def _tendon_objections(self) -> Iterator[str]:
        """Find keys that do not fit the rod's tendons."""
        control, positions = self.control, self.rod.tendon_positions
        count = len(positions)
        exist = {}
        for name in ("agonist", "antagonist"):
            index = getattr(control, name)
            exist[name] = index is not None and index < count
            if index is not None and index >= count:
                yield f"control.{name} = {index}{by_default(control, name)}, but the rod has tendons 0 to {count - 1}"
        across = 0 if control.plane == "xz" else 1
        arm = positions[control.agonist][across] if exist["agonist"] else None
        if arm == 0.0:
            yield (
                f"control.agonist = {control.agonist}{by_default(control, 'agonist')}: that tendon does not bend the "
                f"rod in plane '{control.plane}'{by_default(control, 'plane')}: write another agonist or plane"
            )
        if control.agonist == control.antagonist:
            yield "control.agonist and control.antagonist are the same tendon"
        elif arm and exist["antagonist"] and positions[control.antagonist or 0][across] * arm >= 0.0:
            yield f"control.antagonist = {control.antagonist}: that tendon does not oppose the agonist"
        if self.pretension.antagonist > 0.0 and control.antagonist is None:
            yield "pretension.antagonist needs control.antagonist"
        tight, tension_max = self.pretension, f"limits.tension_max = {self.limits.tension_max:g} N"
        if self.pretension.tension_min >= self.limits.tension_max:
            yield (
                f"pretension.tension_min = {tight.tension_min:g} N{by_default(tight, 'tension_min')} must be below "
                f"{tension_max}: write a lower pretension.tension_min"
            )
        if self.pretension.tension + self.pretension.antagonist > self.limits.tension_max:
            together = tight.tension + tight.antagonist
            yield (
                f"pretension.tension and .antagonist together are above {tension_max}: they are {together:g} N"
                f"{by_default(tight, 'tension', 'antagonist')}: write a lower pretension.tension"
            )
        residual = self.observer.residual
        if residual is not None and len(residual.low) != count:
            yield f"observer.residual.low has {len(residual.low)} numbers, but the rod {count} tendons: train it again"
        if len(self.simulator.rod.tendon_positions) != count:
            yield "rod and simulator.rod differ in the number of tendon_positions"

    def _safety_objections(self) -> Iterator[str]:
        """Give the model the general rod, which [safety] needs; find a configuration that says otherwise."""
        if self.safety is None:
            return
        if self.control.solver == "shooting":
            yield "control.solver = 'shooting', but [safety] needs the general rod: set 'general', or remove the key"
        control = self.control.model_copy(update={"solver": "general"})
        object.__setattr__(self, "control", control)  # frozen for everyone else

    def _servo_objections(self) -> list[str]:
        """List limits that the servos or drives cannot meet; empty without [servo] and [drives]."""
        if self.drives is not None:
            bounds = self.limits
            return drive_objections(
                self.drives,
                self.servo,
                len(self.rod.tendon_positions),
                bounds.tension_max,
                (bounds.displacement_min, bounds.displacement_max),
            )
        if self.servo is None:
            return []
        limits = self.limits
        return servo_objections(
            self.servo,
            len(self.rod.tendon_positions),
            limits.tension_max,
            self.with_own_rates().limits.displacement_rate,
            limits.displacement_min,
            limits.displacement_max,
        )


def parse_config(text: str, source: str) -> RigConfig:
    """Read a configuration from TOML.

    Args:
        text: TOML.
        source: name of the file, for messages.

    Raises:
        ConfigError: invalid TOML, unknown keys, values out of range; all errors at once, one line each.
    """
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{source}: {not_toml(text, error)}") from error
    return check_config(data, source, key_lines(text))


def check_config(data: dict[str, Any], source: str, lines: Mapping[Path, int] | None = None) -> RigConfig:
    """Read a configuration from nested tables; `lines` are those of the keys, for messages."""
    if objection := version_objection(data):  # alone: a newer file may have any number of keys that are unknown here
        line = line_of((KEY,), lines or {})
        raise ConfigError(f"{source}{'' if line is None else f':{line}'}: {objection}")
    data, old = with_new_names(without_version(data), source)
    wrong = [Objection(".".join(path), "", message, path) for path, message in old]
    try:
        config = RigConfig.model_validate(data)
        if not wrong:
            return config
    except ValidationError as error:
        wrong += objections(error, RigConfig)
    wrong = [replace(one, line=line_of(one.path, lines or {})) for one in wrong]
    wrong.sort(key=lambda one: one.line or 0)
    raise ConfigError("\n".join(in_file(one, source) for one in wrong), wrong)
