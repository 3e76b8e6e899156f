"""A live rig relayed to a viewer: the messages on the bus, and the model's rod under the commanded tensions."""

import time
from collections import deque
from contextlib import suppress
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from tendond.bus.client import open_client
from tendond.bus.subscription import Subscription
from tendond.daemon.recording import foxglove, scene
from tendond.daemon.recording.channels import (
    ROD_SHAPE,
    STATUS,
    TIP_MEASURED,
    TIP_MODEL,
    TRANSFORMS,
    TRUTH,
    Channel,
)
from tendond.daemon.recording.contact_scene import contact_entity, no_contact
from tendond.daemon.recording.entities import SceneEntity
from tendond.model import ModelError
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.selection import model_rod
from tendond.offline.viewer.server import Server
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.health import FilterHealth
from tendond.schemas.keys import SIMULATOR_TRUTH, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.keys import STATUS as STATUS_KEY
from tendond.schemas.messages import Message, SimulatorTruth, Status, TendonCommand, TendonState, TipPose
from tendond.schemas.wire import encode

Array = NDArray[np.float64]

COMMAND = Channel("tendon/command", TendonCommand)
TENDONS = Channel("tendon/state", TendonState)
LIVE = (TIP_MEASURED, TIP_MODEL, ROD_SHAPE, TRANSFORMS, STATUS, TRUTH, COMMAND, TENDONS)
"""Channels of a live rig."""

KINDS: dict[str, type[Message]] = {
    TIP_POSE: TipPose,
    TENDON_COMMAND: TendonCommand,
    TENDON_STATE: TendonState,
    STATUS_KEY: Status,
    SIMULATOR_TRUTH: SimulatorTruth,
}
QUEUE = 64
POLL_SECONDS = 0.005
SHAPE_SECONDS = 0.05
PATIENCE_SECONDS = 10.0


def relay(config: RigConfig, server: Server) -> None:
    """Relay a rig until the process is interrupted.

    Raises:
        BusError: there is no controller.
    """
    scene = LiveScene(config, server)
    name = config.rig.name
    next_shape = 0.0
    with open_client(config.bus.endpoint, PATIENCE_SECONDS) as session:
        subscriptions = [Subscription[Any](session, key(name, topic), kind, QUEUE) for topic, kind in KINDS.items()]
        while True:
            for subscription in subscriptions:
                for message in subscription:
                    scene.add(message, time.time_ns())
            if time.monotonic() >= next_shape:
                next_shape = time.monotonic() + SHAPE_SECONDS
                scene.draw(time.time_ns())
            time.sleep(POLL_SECONDS)


class Sink(Protocol):
    """What takes messages for viewers; `Server` is one."""

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """Take a message."""


class LiveScene:
    """The newest messages, and the model's rod.

    Args:
        config: the rig's configuration.
        server: server with the channels `LIVE`.
    """

    def __init__(self, config: RigConfig, server: Sink) -> None:
        self._server = server
        self._rod = model_rod(config)
        self._state = self._rod.solve_static([0.0] * self._rod.parameters.tendon_count)
        self._steps = 0
        self._target: Vector3 = (0.0, 0.0, 0.0)
        self._filter: FilterHealth | None = None
        self._tip: TipPose | None = None
        self._trail: deque[Vector3] = deque(maxlen=scene.TRAIL_POINTS)

    def add(self, message: Message, now_ns: int) -> None:
        """Relay a message; a command advances the rod by a period."""
        put = self._server.put
        match message:
            case TipPose():
                self._tip = message
                pose = foxglove.pose_in_frame(now_ns, message.position, message.orientation)
                put(TIP_MEASURED.topic, encode(pose), now_ns)
            case TendonCommand():
                put(COMMAND.topic, encode(message), now_ns)
                with suppress(ModelError):  # the rod is then drawn in its last shape
                    self._state = self._rod.step(self._state, [max(0.0, pull) for pull in message.tension])
                    self._steps += 1
            case TendonState():
                put(TENDONS.topic, encode(message), now_ns)
            case Status():
                self._target, self._filter = message.target, message.filter
                put(STATUS.topic, encode(message), now_ns)
            case SimulatorTruth():
                put(TRUTH.topic, encode(message), now_ns)

    def draw(self, now_ns: int) -> None:
        """Send the rod's shape, the model's tip and the frames."""
        put, tip = self._server.put, self._tip
        points, end = self._rod.curve(self._state), self._rod.tip(self._state)
        x, y, z = end.position.tolist()
        place = ((x, y, z), quaternion(end.rotation))
        self._trail.append(place[0] if tip is None else tip.position)
        known = self._known(now_ns, points, place[0] if tip is None else tip.position)
        shape = scene.rod_shape(
            now_ns, self._steps, points, self._target, self._rod.tendon_paths(self._state), self._trail, known
        )
        put(ROD_SHAPE.topic, encode(shape), now_ns)
        put(TIP_MODEL.topic, encode(foxglove.pose_in_frame(now_ns, *place)), now_ns)
        frames = {"tip_model": place}
        if tip is not None:
            frames["tip_measured"] = (tip.position, tip.orientation)
        put(TRANSFORMS.topic, encode(foxglove.frame_transforms(now_ns, frames)), now_ns)

    def _known(self, now_ns: int, points: Array, tip: Vector3) -> tuple[SceneEntity, ...]:
        """Draw what the filter knows: the tip's ellipsoid and force, about the measured tip, and a contact."""
        known = self._filter
        if known is None or known.force_vector is None:
            return ()
        spread, force, covariance = known.tip_covariance, known.force_vector, known.force_covariance
        if spread is None or covariance is None:
            return ()
        tip_entity = scene.filter_entity(now_ns, tip, force, spread, covariance)
        found = known.contact
        if found is None:
            return tip_entity, no_contact(now_ns)
        places, length = (found.place, found.first_place, found.last_place), self._rod.parameters.length
        contact = contact_entity(now_ns, points, length, places, found.force, found.force_deviation)
        return tip_entity, contact
