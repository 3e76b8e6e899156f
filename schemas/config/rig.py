"""The rig's configuration: one TOML file, every key with its unit and range; SI throughout."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from ipaddress import ip_address
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator, model_validator

from tendond import TendondError
from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.commissioning import CommissioningSection
from tendond.schemas.config.ranges import NotNegative, Positive
from tendond.schemas.config.rates import with_own_rates
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.renamed import with_new_names
from tendond.schemas.config.servo import ServoSection, servo_objections
from tendond.schemas.config.simulator import Impact, SimulatedMocap, SimulatedServos, Weight
from tendond.schemas.config.vicon import ViconSection
from tendond.schemas.errors.explain import Objection, in_file, objections
from tendond.schemas.errors.keywords import Path
from tendond.schemas.errors.toml_lines import key_lines, line_of
from tendond.schemas.keys import RIG_NAME

Diagonal = tuple[NotNegative, NotNegative, NotNegative]


class ConfigError(TendondError):
    """A configuration that cannot be used: file, key, value, what is allowed; a line each.

    Attributes:
        objections: the same in parts, where there are some.
    """

    def __init__(self, text: str, objections: Sequence[Objection] = ()) -> None:
        self.objections = tuple(objections)
        super().__init__(text)


class RigSection(Schema):
    """[rig]"""

    name: str = Field("paper", description="first part of every Zenoh key")

    @field_validator("name")
    @classmethod
    def _plain(cls, value: str) -> str:
        if not RIG_NAME.fullmatch(value):
            raise ValueError("use 1 to 32 of a-z, 0-9, '-' and '_', starting with a letter or digit")
        return value


class BusSection(Schema):
    """[bus]"""

    endpoint: str = Field("tcp/127.0.0.1:7447", description="Zenoh endpoint on which the controller listens")
    unguarded: bool = Field(False, description="listen beyond this machine without an access list; see deploy/bus")

    @field_validator("endpoint")
    @classmethod
    def _form(cls, value: str) -> str:
        protocol, _, address = value.partition("/")
        host, _, port = address.rpartition(":")
        if protocol not in {"tcp", "tls", "quic"} or not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError("has the form tcp/HOST:PORT, for instance tcp/127.0.0.1:7447")
        return value

    @property
    def is_loopback(self) -> bool:
        """Whether only processes of this machine can reach it."""
        host = self.endpoint.partition("/")[2].rpartition(":")[0].strip("[]")
        if host == "localhost":
            return True
        try:
            return ip_address(host).is_loopback
        except ValueError:
            return False


class RodSection(Schema):
    """[rod] and [simulator.rod]: parameters of the Cosserat rod; the defaults are the paper's robot."""

    length: Annotated[float, Field(gt=0.0, le=10.0, description="[m]")] = 0.5
    radius: Annotated[float, Field(gt=0.0, le=0.1, description="of the backbone [m]")] = 1e-3
    youngs_modulus: Annotated[float, Field(ge=1e6, le=1e12, description="[Pa]")] = 190e9
    poisson_ratio: Annotated[float, Field(ge=0.0, le=0.5, description="[-]")] = 0.3
    density: Annotated[float, Field(gt=0.0, le=1e6, description="with disks, glue, markers [kg/m^3]")] = 17189.0
    shear_damping: Diagonal = Field((0.0, 0.0, 0.0), description="diagonal of Bse [N s]")
    bending_damping: Diagonal = Field((0.008, 0.008, 0.008), description="diagonal of Bbt [N m^2 s]")
    drag: Diagonal = Field((0.1, 0.1, 0.1), description="diagonal of C [kg/m^2]")
    gravity: Vector3 = Field((-9.81, 0.0, 0.0), description="world frame, straight rod along +z [m/s^2]")
    tendon_positions: Annotated[
        tuple[tuple[float, float], ...],
        Field(min_length=1, max_length=16, description="(x, y) of each tendon in the cross-section [m]"),
    ] = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))
    tip_mass: Annotated[float, Field(ge=0.0, le=10.0, description="of a tool or marker body on the tip [kg]")] = 0.0
    tip_inertia: Diagonal = Field((0.0, 0.0, 0.0), description="diagonal about its centre of mass, body frame [kg m^2]")
    tip_offset: Vector3 = Field((0.0, 0.0, 0.0), description="from the tip to its centre of mass, body frame [m]")
    tendon_stiffness: Positive | None = Field(None, description="[N/m]; left out: tendons do not stretch")
    space: Literal["euler", "rk4", "rk6"] = Field("rk6", description="scheme along the rod; euler is the paper's")
    nodes: (
        Annotated[int, Field(ge=2, le=2000, description="along the rod; left out: the scheme's own number")] | None
    ) = None
    alpha: Annotated[float, Field(ge=-0.5, le=0.0, description="of BDF-alpha [-]")] = -0.2


class LoopSection(Schema):
    """[loop]"""

    period: Annotated[float, Field(ge=0.001, le=0.1, description="of the cycle, and time step of the model [s]")] = 0.01
    priority: Annotated[
        int, Field(ge=0, le=98, description="first-in-first-out priority of the loop, where permitted; 0: none")
    ] = 50
    cpu: Annotated[int, Field(ge=0, le=4095)] | None = Field(
        None, description="to which the loop is bound; left out: any"
    )
    rehearse: bool = Field(True, description="work out each cycle just before its deadline; anew if more comes in")
    lock_memory: bool = Field(True, description="keep the process in memory, where permitted")


class ControlSection(Schema):
    """[control]: the law, what feeds it, and the laws' own parameters in tables of their names."""

    law: str = Field("backstepping", description="name of a registered law")
    feedback: Literal["observer", "direct"] = Field(
        "observer",
        description="observer: velocity and acceleration of the model; direct: differences of the measured tip",
    )
    plane: Literal["xz", "yz"] = Field("xz", description="in which the robot bends")
    agonist: Annotated[int, Field(ge=0, le=15, description="index of the tendon that bends towards +x (or +y)")] = 0
    antagonist: Annotated[int, Field(ge=0, le=15)] | None = Field(
        None, description="index of the opposing tendon; left out: the law pulls one tendon only"
    )
    sampled: bool = Field(
        True,
        description="no more tension than takes a velocity error away in one cycle; false: the law as it is written",
    )
    laws: dict[str, dict[str, float]] = Field(
        {}, description="parameters of laws: [control.laws.backstepping] alpha1, alpha2 and so on"
    )


class ObserverSection(Schema):
    """[observer]: how the model is held to the measured tip, and what is known of delays."""

    kind: Literal["force", "offset"] = Field(
        "force", description="force: what the model misses is a force on its tip; offset: it is added to its tip"
    )
    delay: Annotated[float, Field(ge=0.0, le=0.5, description="age of a pose when it arrives [s]")] = 0.0
    lag: Annotated[float, Field(ge=0.0, le=1.0, description="time constant of the actuators [s]")] = 0.0
    tip_mass_max: NotNegative | None = Field(
        None,
        description="on the tip, unknown to the model, that the gains must bear [kg]; none: by the rod's stiffness",
    )
    integral: Annotated[
        float, Field(ge=0.0, le=100.0, description="largest gain of the estimated force [1/s]; the margin lowers it")
    ] = 5.0
    proportional: Annotated[
        float, Field(ge=0.0, le=5.0, description="largest gain that pulls the model's motion [-]; lowered likewise")
    ] = 0.6
    derivative: Annotated[float, Field(ge=0.0, le=1.0, description="largest gain of the same [s]; likewise")] = 0.1
    quiet: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="a smaller mean innovation is held for noise [m]; none: 0.0018 of the rod's length"
    )
    quiet_time: Annotated[float, Field(gt=0.0, le=10.0, description="over which that mean is taken [s]")] = 0.07
    quiet_share: Annotated[float, Field(gt=0.0, le=1.0, description="of the gains that is left for noise [-]")] = 0.5
    force_max: Annotated[float, Field(gt=0.0, le=1000.0)] | None = Field(
        None, description="bound of the estimated force [N]; none: by the rod's stiffness and weight"
    )
    offset_gain: Annotated[float, Field(gt=0.0, le=1.0, description="low-pass of kind 'offset', per cycle [-]")] = 0.2


class LimitsSection(Schema):
    """[limits]: of every command; the servo driver checks its own again."""

    tension_min: NotNegative = Field(0.0, description="[N]")
    tension_max: Annotated[float, Field(gt=0.0, le=500.0, description="[N]")] = 60.0
    tension_rate: NotNegative = Field(
        0.0,
        description="[N/s]; 0: the robot's own, twice what its first natural frequency can follow",
    )
    displacement_min: Annotated[float, Field(le=0.0, ge=-1.0, description="[m]")] = -0.12
    displacement_max: Annotated[float, Field(ge=0.0, le=1.0, description="[m]")] = 0.12
    displacement_rate: NotNegative = Field(0.0, description="[m/s]; 0: the robot's own, as for tension_rate")
    input_gain_min: Annotated[float, Field(gt=0.0, le=1e3)] = Field(
        1.0, description="b_c vanishes as the rod straightens; below this it has no direction [m/s^2/N]"
    )
    slack: Annotated[float, Field(ge=0.0, le=0.05)] = Field(
        0.0, description="by which a tendon without tension is let out beyond the model's length [m]"
    )
    release_rate: Positive = Field(60.0, description="of the tension while it is released [N/s]")
    limit_time: Positive = Field(1.0, description="[s]; a command that stands at a limit for so long is a fault")

    @model_validator(mode="after")
    def _ordered(self) -> "LimitsSection":
        if self.tension_min >= self.tension_max:
            raise ValueError("tension_min must be below tension_max")
        return self


class PretensionSection(Schema):
    """[pretension]: what the agonist is brought to between arming and tracking."""

    tension: NotNegative = Field(0.5, description="[N]; a straight rod gives the laws nothing to pull with")
    antagonist: NotNegative = Field(
        0.0, description="least tension of both tendons of the pair while the law pulls, where there is a pair [N]"
    )
    least: NotNegative = Field(
        1.0, description="least tension of every tendon under a law that moves the tip in space [N]"
    )
    duration: Annotated[float, Field(ge=0.0, le=60.0, description="[s]")] = 0.2


class FaultsSection(Schema):
    """[faults]: how much is borne before the arm is released."""

    pose_timeout: Annotated[
        float, Field(gt=0.0, le=10.0, description="[s]; without a new pose for longer, the observer gives up")
    ] = 0.2
    rejected_time: Positive = Field(0.2, description="[s]; of poses that are all rejected")
    tip_speed_max: Positive = Field(
        20.0, description="a pose that implies more is a teleport; 10 N fling the paper's robot at 17 m/s [m/s]"
    )
    teleport_margin: NotNegative = Field(0.02, description="that a pose may jump beyond it [m]")
    teleport_time: Positive = Field(0.05, description="[s]; from the first to the newest of such poses in a row")
    solver_timeout: NotNegative = Field(0.05, description="[s]; that the last good model state is kept")
    overrun_time: Positive = Field(0.1, description="[s]; of deadlines missed in a row")
    tendon_timeout: Annotated[
        float, Field(gt=0.0, le=60.0, description="[s]; without a tendon state, once there has been one")
    ] = 0.5
    frozen_time: Positive = Field(0.2, description="[s]; of new poses that are all equal to the last bit")
    source_time: Positive = Field(
        1.0, description="[s]; another publisher or controller that is silent for longer is gone"
    )
    equal_way: Positive = Field(0.01, description="that the model's tip goes meanwhile, for them to be a fault [m]")
    mismatch: Annotated[
        float, Field(gt=0.0, description="distance of model and measured tip, as a part of the rod's length [-]")
    ] = 0.3
    mismatch_time: Positive = Field(1.0, description="[s]; at more than it is a fault")
    slack_part: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.2, description="of the model's tension; a tendon that reports less does not pull; 0: not watched [-]"
    )
    slack_tension: Positive = Field(5.0, description="of the model, from which on a tendon is watched for that [N]")
    slack_time: Positive = Field(0.2, description="[s]; of reports without pull that are a fault")
    tracking_error: Positive = Field(
        0.07, description="distance of the tip from a reference that rests, as a part of the rod's length [-]"
    )
    tracking_time: Positive = Field(1.5, description="[s]; at more than it is a fault")
    swing: Positive = Field(0.01, description="of the tip that does not die down, as a part of the rod's length [-]")
    tension_swing: Positive = Field(0.15, description="of a command that does not, as a part of limits.tension_max [-]")
    orientation: Positive = Field(
        0.8, description="between the measured tip and the model's in the same place [rad]; not with orientation 3.2"
    )
    orientation_time: Positive = Field(1.0, description="[s]; at more than it is a fault")
    jump: Positive = Field(0.02, description="of a resting tip between two poses, as a part of the rod's length [-]")
    load_margin: Positive = Field(
        0.25, description="of limits.tension_max, by which a report may be above it, or above twice the model's [-]"
    )
    report_time: Positive = Field(
        0.1, description="[s]; of reports beyond that, or far beyond the displacement's range"
    )
    pose_age: Positive = Field(0.05, description="[s]; by which a pose may be older than observer.delay, by its stamp")
    age_time: Positive = Field(0.2, description="[s]; of poses that are all older")


class SimulatorSection(Schema):
    """[simulator]"""

    period: Annotated[float, Field(ge=0.0001, le=0.1, description="between poses, and time step of the plant [s]")] = (
        0.01
    )
    rod: RodSection = Field(RodSection(), description="the plant's own parameters")
    drive: Literal["tension", "displacement"] = Field(
        "tension",
        description="tension: ideal, as in the paper; displacement: tendons are elastic strings wound by servos",
    )
    weight: Weight = Weight()
    impacts: tuple[Impact, ...] = Field((), description="pushes against the rod")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="of everything random: the same seed, the same run")
    servo: SimulatedServos = SimulatedServos()
    mocap: SimulatedMocap = SimulatedMocap()


class LogSection(Schema):
    """[log]"""

    queue: Annotated[int, Field(ge=10, description="entries between the loop and the recorder")] = 4000
    shape_period: Annotated[int, Field(ge=1, description="cycles between two rod shapes in the log")] = 5
    split_size: Annotated[
        float, Field(ge=0.1, le=1e6, description="of a file, from which on the run goes on in another one [MB]")
    ] = 1000.0
    split_time: Annotated[float, Field(ge=1.0, le=1e7, description="the same, by the file's age [s]")] = 3600.0
    idle_period: Annotated[
        float, Field(ge=0.0, le=3600.0, description="[s]; while idle, a tenth of a second in so many is logged; 0: all")
    ] = 60.0
    keep_size: Annotated[float, Field(ge=0.0, le=1e6)] | None = Field(
        None,
        description="[GB] of logs of this rig, the oldest are removed; 0: no bound; left out: 20 or a tenth of the disk"
        " for a service, no bound by hand",
    )
    keep_days: Annotated[float, Field(ge=0.0, le=1e5)] | None = Field(
        None, description="[days] that they are kept; 0: no bound; left out: 90 for a service, no bound by hand"
    )


class RigConfig(Schema):
    """A rig: everything that the controller and the simulator need to know."""

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
    servo: ServoSection | None = None

    def with_own_rates(self) -> "RigConfig":
        """The configuration with the robot's own rates in [limits] where none are named."""
        limits = with_own_rates(self.limits, self.rod, self.observer.lag, self.loop.period)
        return self if limits is self.limits else self.model_copy(update={"limits": limits})

    @model_validator(mode="after")
    def _consistent(self) -> "RigConfig":
        if wrong := [*self._tendon_objections(), *self._servo_objections()]:
            raise ValueError("\n".join(wrong))
        return self

    def _tendon_objections(self) -> Iterator[str]:
        """What does not fit the rod's tendons, in words."""
        control, positions = self.control, self.rod.tendon_positions
        count = len(positions)
        exist = {}
        for name in ("agonist", "antagonist"):
            index = getattr(control, name)
            exist[name] = index is not None and index < count
            if index is not None and index >= count:
                yield f"control.{name} = {index}, but the rod has tendons 0 to {count - 1}"
        across = 0 if control.plane == "xz" else 1
        arm = positions[control.agonist][across] if exist["agonist"] else None
        if arm == 0.0:
            yield (f"control.agonist = {control.agonist}: that tendon does not bend the rod in plane '{control.plane}'")
        if control.agonist == control.antagonist:
            yield "control.agonist and control.antagonist are the same tendon"
        elif arm and exist["antagonist"] and positions[control.antagonist or 0][across] * arm >= 0.0:
            yield f"control.antagonist = {control.antagonist}: that tendon does not oppose the agonist"
        if self.pretension.antagonist > 0.0 and control.antagonist is None:
            yield "pretension.antagonist needs control.antagonist"
        if self.pretension.least >= self.limits.tension_max:
            yield "pretension.least must be below limits.tension_max"
        if self.pretension.tension + self.pretension.antagonist > self.limits.tension_max:
            yield "pretension.tension and .antagonist together are above limits.tension_max"
        if len(self.simulator.rod.tendon_positions) != count:
            yield "rod and simulator.rod differ in the number of tendon_positions"

    def _servo_objections(self) -> list[str]:
        """What servos cannot do; without [servo] there are none."""
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
    """The configuration in a TOML text.

    Args:
        text: TOML.
        source: name of the file, for messages.

    Raises:
        ConfigError: no TOML, unknown keys, values out of range; every error at once, a line each.
    """
    try:
        data: dict[str, Any] = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{source}: is no TOML: {error}") from error
    return check_config(data, source, key_lines(text))


def check_config(data: dict[str, Any], source: str, lines: Mapping[Path, int] | None = None) -> RigConfig:
    """As `parse_config`, from the nested tables; `lines` says where their keys stand, for messages."""
    data, old = with_new_names(data, source)
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
