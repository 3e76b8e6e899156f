"""What is on the bus: each key, the message on it, who says it and who hears it."""

from dataclasses import dataclass
from typing import Literal

from tendond.schemas import keys
from tendond.schemas.base import Schema
from tendond.schemas.faults import FaultRequest
from tendond.schemas.messages import (
    ControlAction,
    ControlReply,
    ControlRequest,
    ServoHealth,
    SimulatorTruth,
    Status,
    TendonCommand,
    TendonState,
    TipPose,
)


@dataclass(frozen=True)
class Topic:
    """A key below the rig's name.

    Attributes:
        name: of the key, after `<rig>/`.
        kind: published; request: a query that is answered; token: there or not.
        message: published, or asked with; none where there is no payload.
        reply: to a request.
        by, to: who publishes or asks, and who hears or answers; commands.
        meaning: in a few words.
    """

    name: str
    kind: Literal["published", "request", "token"]
    message: type[Schema] | None
    reply: type[Schema] | None
    by: str
    to: str
    meaning: str


_DRIVERS = "simulate, servo"
_VIEWERS = "watch, view"
_REQUESTS = {
    ControlAction.ARM: "pretension, then track the reference",
    ControlAction.PROBE: "pull each tendon a little, compare the tip's motion with the model's, let go",
    ControlAction.STOP: "stop tracking and release the tendons",
    ControlAction.RESET: "leave the fault mode",
    ControlAction.STATUS: "tell the status",
    ControlAction.REFERENCE: "another reference, while idle",
    ControlAction.LAW: "another law, while idle",
}

TOPICS = (
    Topic(keys.TIP_POSE, "published", TipPose, None, "vicon, simulate", f"run, {_VIEWERS}", "pose of the tip"),
    Topic(
        keys.TENDON_COMMAND, "published", TendonCommand, None, "run", f"{_DRIVERS}, {_VIEWERS}",
        "what the servos are to do, every cycle, armed or not",
    ),
    Topic(
        keys.TENDON_STATE, "published", TendonState, None, _DRIVERS, f"run, {_VIEWERS}", "what the servos report",
    ),
    Topic(
        keys.SERVO_HEALTH, "published", ServoHealth, None, "servo", "demo, whoever subscribes",
        "what the servos' serial bus loses and how long it takes, once a second",
    ),
    Topic(keys.STATUS, "published", Status, None, "run", _VIEWERS, "the controller's state, each second and on change"),
    Topic(
        keys.SIMULATOR_TRUTH, "published", SimulatorTruth, None, "simulate", "run (to log it), view",
        "what the simulated rod really does",
    ),
    *(
        Topic(f"{keys.CONTROL}/{action.value}", "request", ControlRequest, ControlReply, action.value, "run", meaning)
        for action, meaning in _REQUESTS.items()
    ),
    Topic(
        keys.SERVO_RESET, "request", None, ControlReply, "servo reset", "servo",
        "leave the driver's fault, or open its port again",
    ),
    Topic(
        keys.SIMULATOR_INJECT, "request", FaultRequest, ControlReply, "inject", "simulate", "cause a fault, or mend it"
    ),
    Topic(keys.ALIVE, "token", None, None, "run", "whoever asks for liveliness", "there while the controller is"),
    Topic(
        f"{keys.ALIVE}/*", "token", None, None, "run", "run, whoever asks for liveliness",
        "the controller's identity, once it is ready: a second controller of the rig ends",
    ),
)  # fmt: skip
