"""The bridge's process: a rig's messages to ROS 2 as they come, goals and calls from ROS 2 to the controller.

On the rig's bus it is a client that subscribes, and asks what an operator asks; the loop knows nothing of it.
"""

import gc
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import zenoh

from tendond.bus.client import BusError, StoppedError
from tendond.bus.operator import ask, status_in
from tendond.bus.subscription import Subscription
from tendond.drivers.host import Host, await_controller
from tendond.drivers.ros2.description import controller_health, urdf
from tendond.drivers.ros2.distributions import DEFAULT_DISTRIBUTION, ROUTER
from tendond.drivers.ros2.goals import RefusedError, check_stamp, goal_request
from tendond.drivers.ros2.messages import Health, Level, RigMessages
from tendond.drivers.ros2.names import Attachment
from tendond.drivers.ros2.node import Call, Node, Publisher, open_router
from tendond.drivers.ros2.operator import Operator
from tendond.drivers.ros2.shape import Shape
from tendond.drivers.ros2.topics import RigTopics, Topic
from tendond.drivers.ros2.types import TRIGGER, MalformedError, part_of, types_of
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import STATUS, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import Status, TendonCommand, TendonState, TipPose
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

QUEUE = 64
WAIT_SECONDS = 0.05
SHAPE_SECONDS = 0.05
"""Time between two pictures of the rod [s]: enough for the eye, a twentieth of what a picture a cycle would cost."""

HEALTH_SECONDS = 1.0
SILENCE_SECONDS = 3.0
"""Time without a status, which comes each second, after which the controller's health is stale [s]."""

ROUTER_SECONDS = 5.0
CLOCK_SECONDS = 1.0
"""Age beyond which a stamp is taken for another host's clock, and the arrival is given instead [s]."""

CALLS = (ControlAction.ARM, ControlAction.STOP, ControlAction.RESET, ControlAction.STATUS)
"""Actions that are services of type std_srvs/srv/Trigger."""


@dataclass(frozen=True)
class RosOptions:
    """Where ROS 2 is: distribution, ROS_DOMAIN_ID, endpoint of its router."""

    distribution: str = DEFAULT_DISTRIBUTION
    domain: int = 0
    router: str = ROUTER


class Bridge:
    """Bridge of a rig to ROS 2.

    Args:
        config: of the rig.
        options: where ROS 2 is.
        host: surroundings of the process.
    """

    def __init__(self, config: RigConfig, options: RosOptions, host: Host) -> None:
        self._config, self._options, self._host = config, options, host
        self._types = types_of(options.distribution)
        self._topics = RigTopics(config.rig.name)
        self._messages = RigMessages(self._types, config.rig.name)
        self._shape = Shape(config)
        self._health: Health | None = None
        self._heard = 0.0
        self._publishers: dict[Topic, Publisher] = {}

    def run(self) -> None:
        """Relay until stopped.

        Raises:
            BusError: no controller. RouterError: no router of ROS 2.
        """
        try:
            with (
                open_router(self._options.router, ROUTER_SECONDS, self._host.stopped) as ros,
                await_controller(self._config, self._host.stopped) as bus,
            ):
                operator = Operator(partial(_ask, bus, self._config.rig.name))
                self._join(ros, operator)
                gc.collect()
                gc.freeze()  # else a full collection, of all that was imported, delays a pose by milliseconds
                self._host.supervisor.ready("connected")
                self._relay(bus, operator)
        except StoppedError:
            return
        finally:
            self._host.supervisor.stopping()

    def _join(self, session: zenoh.Session, operator: Operator) -> None:
        """Declare what the rig has in the graph of ROS 2."""
        node = Node(session, self._types, self._options.domain, self._topics.namespace, "tendond")
        self._publishers = {topic: node.publisher(topic) for topic in self._topics.published}
        self._publish(self._topics.description, self._messages.text(urdf(self._config, self._messages)))
        for topic in (self._topics.goal_point, self._topics.goal_pose):
            node.subscribe(topic, partial(self._take_goal, operator, topic))
        for action in CALLS:
            node.serve(self._topics.service(action.value), TRIGGER, partial(self._take_call, operator, action))

    def _relay(self, bus: zenoh.Session, operator: Operator) -> None:
        arrived, name = threading.Event(), self._config.rig.name
        poses = Subscription(bus, key(name, TIP_POSE), TipPose, QUEUE, arrived)
        states = Subscription(bus, key(name, TENDON_STATE), TendonState, QUEUE, arrived)
        commands = Subscription(bus, key(name, TENDON_COMMAND), TendonCommand, QUEUE, arrived)
        statuses = Subscription(bus, key(name, STATUS), Status, QUEUE, arrived)
        next_shape = next_health = 0.0
        while not self._host.stopped():
            self._host.supervisor.alive()
            arrived.wait(WAIT_SECONDS)
            arrived.clear()
            for pose in poses:
                self._send_pose(pose)
            for state in states:
                stamp = wall_time(state.stamp_ns)
                joints = self._messages.joints(stamp, state.displacement, state.tension)
                self._publish(self._topics.tendon_state, joints)
            commanded = False
            for command in commands:
                commanded = True
                stamp = wall_time(command.stamp_ns)
                joints = self._messages.joints(stamp, command.displacement, command.tension)
                self._publish(self._topics.tendon_command, joints)
                self._shape.advance(command)
            for status in statuses:
                self._send_status(status)
            now = time.monotonic()
            # behind a command, when the next pose is a cycle away: a picture takes a while
            if now >= next_shape and (commanded or now >= next_shape + SHAPE_SECONDS):
                next_shape = now + SHAPE_SECONDS
                self._send_shape()
            if now >= next_health:
                next_health = now + HEALTH_SECONDS
                unreadable = sum(sum(one.unreadable.values()) for one in (poses, states, commands, statuses))
                self._send_health(operator, unreadable)

    def _send_pose(self, pose: TipPose) -> None:
        if not pose.valid:  # the last one again, while the tip is occluded
            return
        stamp, place = wall_time(pose.stamp_ns), (pose.position, pose.orientation)
        self._publish(self._topics.tip_pose, self._messages.pose(stamp, place))
        self._publish(self._topics.transforms, self._messages.transforms(stamp, {self._messages.tip: place}))

    def _send_status(self, status: Status) -> None:
        stamp = wall_time(status.stamp_ns)
        self._heard, self._health = time.monotonic(), controller_health(status)
        self._shape.target = status.target
        self._publish(self._topics.diagnostics, self._messages.diagnostics(stamp, [self._health]))
        self._publish(self._topics.reference, self._messages.point(stamp, status.target))
        known = status.filter
        if known is not None and known.tip and known.tip_orientation and known.tip_covariance:
            place = (known.tip, known.tip_orientation)
            estimate = self._messages.estimate(stamp, place, known.tip_covariance)
            self._publish(self._topics.tip_estimate, estimate)

    def _send_shape(self) -> None:
        now, place = time.time_ns(), self._shape.tip()
        self._publish(self._topics.transforms, self._messages.transforms(now, {self._messages.model_tip: place}))
        self._publish(self._topics.rod, self._messages.markers(now, *self._shape.lines(), self._shape.target))

    def _send_health(self, operator: Operator, unreadable: int) -> None:
        """Report the bridge's health, and that of a controller which is silent."""
        refused = sum(operator.refused.values())
        values = {
            "refused": ", ".join(f"{count} {what}" for what, count in operator.refused.items()) or "nothing",
            "last refusal": operator.last_refusal,
            "published": str(sum(one.count for one in self._publishers.values())),
            "unreadable": str(unreadable),
        }
        message = f"last refusal: {operator.last_refusal}" if refused else "relays"
        found: list[Health] = [
            (Level.WARN if refused else Level.OK, f"tendond {self._config.rig.name}: bridge", message, values)
        ]
        silence = time.monotonic() - self._heard
        if silence > SILENCE_SECONDS:
            words = "no status of the controller yet" if self._health is None else f"no status for {silence:.0f} s"
            found.append((Level.STALE, f"tendond {self._config.rig.name}: controller", words, {}))
        self._publish(self._topics.diagnostics, self._messages.diagnostics(time.time_ns(), found))

    def _publish(self, topic: Topic, message: Any) -> None:
        self._publishers[topic].publish(message)

    def _take_goal(self, operator: Operator, topic: Topic, payload: bytes, _: Attachment | None) -> None:
        try:
            wanted = goal_request(self._config, self._messages, topic.type_name, payload, time.time_ns())
        except RefusedError as error:
            self._host.say(f"refused: {operator.refuse(topic.name, str(error))}")
            return
        operator.submit(wanted, partial(_report, self._host.say, topic.name))

    def _take_call(self, operator: Operator, action: ControlAction, call: Call) -> None:
        def done(success: bool, message: str) -> None:
            call.reply(self._types.make(part_of(TRIGGER, "Response"), success=success, message=message))

        try:
            if action is not ControlAction.STOP:  # which is carried out however it was asked for
                self._check_call(call)
        except RefusedError as error:
            done(False, operator.refuse(action.value, str(error)))
            return
        operator.submit(ControlRequest(action=action), done)

    def _check_call(self, call: Call) -> None:
        """Refuse a malformed or old call.

        Raises:
            RefusedError: says why.
        """
        try:
            self._types.decode(part_of(TRIGGER, "Request"), call.payload)
        except MalformedError as error:
            raise RefusedError(f"the call is malformed: {error}") from error
        if call.attachment is None:
            raise RefusedError("the call has no attachment of rmw_zenoh: is the client another middleware's?")
        check_stamp(call.attachment.stamp_ns, time.time_ns(), "the call")


def wall_time(stamp_ns: int) -> int:
    """Return the wall-clock time of a stamp on this host's monotonic clock [ns]; now for a stamp of another clock."""
    now, age = time.time_ns(), time.monotonic_ns() - stamp_ns
    return now - age if abs(age) <= 1e9 * CLOCK_SECONDS else now


def _ask(session: zenoh.Session, rig: str, wanted: ControlRequest) -> ControlReply:
    """Send a request as an operator's command does; a status is put in words.

    Raises:
        BusError: there is no controller, or no reply.
    """
    try:
        reply = ask(session, rig, wanted)
    except zenoh.ZError as error:
        raise BusError(f"no controller of rig '{rig}' can be asked: {error}") from error
    if wanted.action is not ControlAction.STATUS:
        return reply
    status = status_in(reply)
    return reply.model_copy(update={"message": f"{status.mode.value}: {status.reason}"})


def _report(say: Callable[[str], None], topic: str, success: bool, message: str) -> None:
    say(f"{topic}: {'' if success else 'refused: '}{message}")
