"""Topics of the bus: key, message, publishers and subscribers."""

from dataclasses import dataclass
from typing import Literal

from tendond.schemas import keys
from tendond.schemas.base import Schema
from tendond.schemas.faults import FaultRequest
from tendond.schemas.messages import (
    SensorReading,
    ServoHealth,
    SimulatorTruth,
    Status,
    TendonCommand,
    TendonState,
    TipPose,
)
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest


@dataclass(frozen=True)
class Topic:
    """Topic below the rig's name.

    Attributes:
        name: last part of the key, after `<rig>/`.
        kind: published; request: a query with a reply; token: a liveliness token.
        message: published, or sent with the request; none without a payload.
        reply: type of the reply to a request.
        by, to: commands that publish or request, and that subscribe or reply.
        meaning: short description.
    """

    name: str
    kind: Literal["published", "request", "token"]
    message: type[Schema] | None
    reply: type[Schema] | None
    by: str
    to: str
    meaning: str


_DRIVERS = "simulate, servo"
_VIEWERS = "watch, view, bridge, dashboard"
_REQUESTS = {
    ControlAction.ARM: "pretension, then track the reference",
    ControlAction.PROBE: "pull each tendon a little, compare the tip's motion with the model's, release",
    ControlAction.STOP: "stop tracking and release the tendons",
    ControlAction.RESET: "leave the fault mode",
    ControlAction.STATUS: "return the status",
    ControlAction.REFERENCE: "select another reference, while idle",
    ControlAction.LAW: "select another law, while idle",
    ControlAction.JOG: "move the target at a speed, while tracking, until the next request or a timeout",
    ControlAction.SET: "tune gains and limits; some only while idle",
}


def _asked_by(action: ControlAction) -> str:
    """Name the commands that send a request."""
    return action.value if action is ControlAction.PROBE else f"{action.value}, dashboard"


TOPICS = (
    Topic(keys.TIP_POSE, "published", TipPose, None, "mocap, simulate", f"run, {_VIEWERS}", "pose of the tip"),
    Topic(
        keys.TENDON_COMMAND, "published", TendonCommand, None, "run", f"{_DRIVERS}, {_VIEWERS}",
        "command to the servos, every cycle, armed or not",
    ),
    Topic(
        keys.TENDON_STATE, "published", TendonState, None, _DRIVERS, f"run, {_VIEWERS}", "report of the servos",
    ),
    Topic(
        f"{keys.SENSOR}/*", "published", SensorReading, None, "simulate, drivers of sensors", "run, doctor",
        "reading of a sensor beside the pose, by its name in `[[sensors]]`",
    ),
    Topic(
        keys.SERVO_HEALTH, "published", ServoHealth, None, "servo", "demo, other subscribers",
        "losses and round trips of the servos' serial bus, once a second",
    ),
    Topic(keys.STATUS, "published", Status, None, "run", _VIEWERS, "the controller's state, each second and on change"),
    Topic(
        keys.SIMULATOR_TRUTH, "published", SimulatorTruth, None, "simulate", "run (to log it), view, dashboard",
        "true state of the simulated rod",
    ),
    *(
        Topic(
            f"{keys.CONTROL}/{action.value}", "request", ControlRequest, ControlReply, _asked_by(action), "run", meaning
        )
        for action, meaning in _REQUESTS.items()
    ),
    Topic(
        keys.SERVO_RESET, "request", None, ControlReply, "servo reset", "servo",
        "reset the driver's fault, or open its port again",
    ),
    Topic(
        keys.SIMULATOR_INJECT, "request", FaultRequest, ControlReply, "inject", "simulate", "cause a fault, or clear it"
    ),
    Topic(keys.ALIVE, "token", None, None, "run", "liveliness subscribers", "present while the controller runs"),
    Topic(
        f"{keys.ALIVE}/*", "token", None, None, "run", "run, liveliness subscribers",
        "identity of the controller, once it is ready: a second controller of the rig ends",
    ),
)  # fmt: skip
