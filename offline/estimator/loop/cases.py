"""Plants, laws and references of the comparison, as configurations."""

from dataclasses import dataclass, field
from typing import Any, Literal

from tendond.model.rods.selection import model_rod
from tendond.offline.robustness.unlike import load_factor, unlike
from tendond.schemas.config.rig import RigConfig, check_config, parse_config

Kind = Literal["force", "kalman"]

KINDS: tuple[Kind, ...] = ("force", "kalman")
LAWS = ("backstepping", "sliding_mode", "sensitivity")

CAMERA = {"noise": 1e-4, "rotation_noise": 2e-3}
"""Noise of the poses [m, rad]."""

ANGLE = 1.3
"""Bend of the paper's arm at the end of the motion [rad]."""

MOTION = 2.0
"""Duration of the motion [s]."""

CIRCLE = {"kind": "circle", "period": 3.0, "laps": 1, "duration": 1.5}


@dataclass(frozen=True)
class Plant:
    """A plant unlike the model.

    Attributes:
        name: in words. rate: of the loop [Hz].
        stiffness: E of the plant over that of the model. mass: on its tip, unknown [kg], of the paper's robot.
        friction: coefficient of its tendons' friction, of which the model has none.
        delay, late: delay of the poses as configured, and beyond that [cycles].
        robot: preset of model and plant. angle: bend at the end of the motion [rad].
        circle: radius of a circle that laws in space follow, in the robot's length; none: the same motion.
        keys: further keys of the configuration, by section.
    """

    name: str
    rate: float = 100.0
    stiffness: float = 1.0
    mass: float = 0.0
    friction: float = 0.0
    delay: int = 0
    late: int = 0
    robot: str = "paper"
    angle: float = ANGLE
    circle: float | None = 0.5
    keys: dict[str, dict[str, Any]] = field(default_factory=dict)


PLANTS = (
    Plant("like the model"),
    Plant("2 cycles late, E -10 %, 20 g", stiffness=0.9, mass=0.02, delay=2),
    Plant("a cycle later than configured, E +10 %", stiffness=1.1, delay=1, late=1),
    Plant("friction 0.2", friction=0.2, delay=1),
    Plant("friction 0.2, E -10 %, 10 g, 250 Hz", rate=250.0, stiffness=0.9, mass=0.01, friction=0.2, delay=2),
    Plant("50 Hz, E -10 %, 10 g", rate=50.0, stiffness=0.9, mass=0.01, delay=1),
    Plant("two sections, E -10 %", stiffness=0.9, delay=1, robot="rao-2021", angle=0.6, circle=None),
)


def config_of(plant: Plant, law: str, kind: Kind, seed: int = 0) -> RigConfig:
    """Return the configuration of a law on a plant; `seed`: of the noise.

    Raises:
        ConfigError: they do not go together.
    """
    values = parse_config("", "the comparison").model_dump()
    period = 1.0 / plant.rate
    values["loop"]["period"] = period
    if plant.robot != "paper":
        values["rod"] = parse_config(f'[rod]\npreset = "{plant.robot}"\n', plant.robot).rod.model_dump()
        values["simulator"]["rod"] = values["rod"]
    values["control"].update(law=law, solver="general")
    values["observer"].update(kind=kind, delay=plant.delay * period)
    for section, keys in plant.keys.items():
        values[section].update(keys)
    model = check_config(values, plant.name)
    length = model.rod.length
    values["reference"] = {"kind": "minimum_jerk", "angle": plant.angle, "duration": MOTION}
    if law == "sensitivity" and plant.circle is not None:
        values["reference"] = {**CIRCLE, "radius": plant.circle * length}
    values["simulator"] = {
        "period": period,
        "rod": unlike(model.rod, plant.stiffness).model_dump(),
        "solver": "general",
        "seed": seed,
        "weight": {"mass": plant.mass * load_factor(model_rod(model).parameters)},
        "servo": {"friction": plant.friction},
        "mocap": {**CAMERA, "latency": (plant.delay + plant.late) * period},
    }
    values["vicon"] = values["servo"] = None
    return check_config(values, f"{law} on {plant.name}")
