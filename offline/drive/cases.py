"""Chains of the study: each cause of the circle's error alone, and all, with what is configured of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from tendond.schemas.assumed_rig import (
    BACKLASH,
    COMMAND_DELAY,
    FRICTION,
    POSE_DELAY,
    POSE_NOISE,
    RESOLUTION,
    SERVO_ACCELERATION,
    SERVO_LAG,
    SERVO_RATE,
)
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import RigConfig, check_config, parse_config

Section = Mapping[str, float]

IDEAL_SERVO: Section = dict.fromkeys(("rate", "acceleration", "lag", "backlash", "resolution", "friction"), 0.0)
IDEAL_CAMERA: Section = {"noise": 0.0, "latency": 0.0}
NOTHING: Section = {"delay": 0.0, "command_delay": 0.0, "servo_acceleration": 0.0, "backlash": 0.0}

CAMERA: Section = {"noise": POSE_NOISE, "latency": POSE_DELAY}
KNOWS_CAMERA: Section = {**NOTHING, "delay": POSE_DELAY}
CONFIGURED: Section = {
    "delay": POSE_DELAY,
    "command_delay": COMMAND_DELAY,
    "servo_acceleration": SERVO_ACCELERATION,
    "backlash": BACKLASH,
}
REAL: Section = {
    "rate": SERVO_RATE,
    "acceleration": SERVO_ACCELERATION,
    "lag": SERVO_LAG,
    "backlash": BACKLASH,
    "resolution": RESOLUTION,
    "friction": FRICTION,
}

EMULATED_DELAY = COMMAND_DELAY + 0.005
"""Dead time through emulated servos, which a command reaches half a cycle later [s]."""


@dataclass(frozen=True)
class Case:
    """A chain on which the circle is run.

    Attributes:
        name: in words.
        servo: keys of [simulator.servo]. camera: of [simulator.mocap]. configured: of [observer].
        friction: coefficient of friction of the controller's model.
        emulated: emulated servos take the place of the simulated ones.
        goal: everything is configured, and the goals are to be met.
    """

    name: str
    servo: Section = field(default_factory=lambda: IDEAL_SERVO)
    camera: Section = field(default_factory=lambda: IDEAL_CAMERA)
    configured: Section = field(default_factory=lambda: NOTHING)
    friction: float = 0.0
    emulated: bool = False
    goal: bool = False


def cases() -> list[Case]:
    """List the chains."""
    alone = [
        Case(f"{word} alone", servo={**IDEAL_SERVO, **{key: REAL[key] for key in keys}})
        for word, keys in (
            ("steps of 0.088 degrees", ("resolution",)),
            ("backlash", ("backlash",)),
            ("friction", ("friction",)),
            ("profile", ("rate", "acceleration")),
            ("lag", ("lag",)),
        )
    ]
    camera = Case("pose delay and noise alone", camera=CAMERA, configured=KNOWS_CAMERA)
    real = Case("all configured but the servos", REAL, CAMERA, KNOWS_CAMERA, FRICTION)
    inverted = {**CONFIGURED, "command_delay": 0.004, "lag": SERVO_LAG}
    wrong = [
        Case(
            f"all, {word} at {percent} %", REAL, CAMERA, {**CONFIGURED, key: 0.01 * percent * CONFIGURED[key]}, FRICTION
        )
        for word, key in (("dead time", "command_delay"), ("backlash", "backlash"), ("profile", "servo_acceleration"))
        for percent in (50, 150)
    ]
    wrong += [
        Case(f"all, friction at {percent} %", REAL, CAMERA, CONFIGURED, 0.01 * percent * FRICTION)
        for percent in (50, 150)
    ]
    frictions = [
        Case(
            f"all configured, friction {coefficient:g}",
            {**REAL, "friction": coefficient},
            CAMERA,
            CONFIGURED,
            coefficient,
            goal=coefficient <= FRICTION,
        )
        for coefficient in (0.1, 0.3)
    ]
    emulated = {**CONFIGURED, "command_delay": EMULATED_DELAY}
    return [
        Case("ideal servos on elastic tendons"),
        camera,
        *alone,
        Case("friction alone, configured", {**IDEAL_SERVO, "friction": FRICTION}, friction=FRICTION),
        real,
        Case("all configured, the lag inverted", REAL, CAMERA, inverted, FRICTION),
        Case("all configured but friction: profile 'rig'", REAL, CAMERA, CONFIGURED),
        Case("all configured", REAL, CAMERA, CONFIGURED, FRICTION, goal=True),
        *frictions,
        *wrong,
        Case("emulated servos, all configured", REAL, CAMERA, emulated, FRICTION, emulated=True, goal=True),
    ]


def config_of(case: Case, period: float) -> RigConfig:
    """Return the configuration of a case: the circle of 250 mm in `period` [s] on the paper's robot."""
    values: dict[str, Any] = parse_config(RIG, "profile 'rig'").model_dump()
    values["control"]["law"] = "sensitivity"
    values["reference"] = {"kind": "circle", "radius": 0.25, "period": period, "duration": 2.0}
    values["observer"].update(case.configured)
    values["simulator"]["servo"] = dict(case.servo)
    values["simulator"]["mocap"].update(case.camera)
    values["rod"]["tendon_friction"] = case.friction
    if case.emulated:
        values["servo"] = {}
    return check_config(values, f"case '{case.name}'")
