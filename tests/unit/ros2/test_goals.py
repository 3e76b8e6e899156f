"""Goals become references of the rig's own kind, and requests of ROS 2 are carried out in time or not at all."""

import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from tendond.bus.client import BusError
from tendond.drivers.ros2 import operator as requests
from tendond.drivers.ros2.goals import RefusedError, goal_request
from tendond.drivers.ros2.messages import RigMessages
from tendond.drivers.ros2.operator import WAITING_MAX, Operator
from tendond.drivers.ros2.topics import POINT, POSE
from tendond.drivers.ros2.types import types_of
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

NOW = 1_700_000_000_000_000_000
PLACE = (0.1, 0.0, 0.4)
TURN = (0.6, 0.0, 0.8, 0.0)
STOP, ARM = ControlRequest(action=ControlAction.STOP), ControlRequest(action=ControlAction.ARM)


def asked(reference: dict[str, Any], place: Vector3 = PLACE, turn: Quaternion | None = None) -> ReferenceSection:
    """The reference that a goal asks for on a rig with this [reference]."""
    config = RigConfig().model_copy(update={"reference": ReferenceSection.model_validate(reference)})
    messages = RigMessages(types_of("jazzy"), "paper")
    message = messages.point(NOW, place) if turn is None else messages.pose(NOW, (place, turn))
    found = goal_request(config, messages, POINT if turn is None else POSE, messages.types.encode(message), NOW)
    assert found.action is ControlAction.REFERENCE
    assert found.reference is not None
    return found.reference


def test_a_goal_replaces_the_target_and_leaves_the_rest_of_the_reference() -> None:
    configured = {"across": 0.3, "kind": "minimum_jerk", "duration": 3.0, "unreachable": "track", "branch": 1}
    found = asked(configured)
    assert (found.position, found.across) == (PLACE, None)
    assert (found.kind, found.duration, found.unreachable, found.branch) == ("minimum_jerk", 3.0, "track", 1)


@pytest.mark.parametrize("kind", ["circle", "helix", "line", "figure_eight"])
def test_a_goal_in_space_is_a_point(kind: str) -> None:
    found = asked({"kind": kind, "moved_max": 0.03})
    assert (found.kind, found.position, found.moved_max) == ("point", PLACE, 0.03)


def test_a_robot_of_poses_takes_an_orientation_and_others_refuse_it() -> None:
    found = asked({"kind": "pose", "position": PLACE, "turned_max": 0.1}, turn=TURN)
    assert (found.kind, found.position, found.orientation, found.turned_max) == ("pose", PLACE, TURN, 0.1)
    with pytest.raises(RefusedError, match="send a PointStamped to goal_point"):
        asked({}, turn=TURN)


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0, 0.0), (1.0, 1.0, 0.0, 0.0), (float("nan"), 0.0, 0.0, 1.0)])
def test_what_is_no_orientation_is_refused(turn: Quaternion) -> None:
    with pytest.raises(RefusedError, match="no unit quaternion"):
        asked({"kind": "pose", "position": PLACE}, turn=turn)


class Controller:
    """A controller that replies when it is let go."""

    def __init__(self) -> None:
        self.asked: list[ControlAction] = []
        self.free = threading.Event()

    def __call__(self, request: ControlRequest) -> ControlReply:
        self.asked.append(request.action)
        if request.action is not ControlAction.STOP:
            assert self.free.wait(30.0)
        return ControlReply(done=True, message="done")


@pytest.fixture
def controller() -> Iterator[Controller]:
    found = Controller()
    yield found
    found.free.set()


class Replies:
    """Replies to requests, which come from other threads."""

    def __init__(self) -> None:
        self.found: list[tuple[bool, str]] = []

    def __call__(self, done: bool, message: str) -> None:
        self.found.append((done, message))

    def wait(self, count: int) -> list[tuple[bool, str]]:
        deadline = time.monotonic() + 30.0
        while len(self.found) < count:
            assert time.monotonic() < deadline
            time.sleep(0.005)
        return self.found


def test_a_stop_passes_everything_that_waits(controller: Controller) -> None:
    operator, stopped = Operator(controller), Replies()
    for _ in range(WAITING_MAX):
        operator.submit(ARM, Replies())
    operator.submit(STOP, stopped)
    assert stopped.wait(1) == [(True, "done")]
    assert controller.asked.count(ControlAction.ARM) <= 1


def test_a_request_that_waited_too_long_is_not_carried_out(
    controller: Controller, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(requests, "WAIT_SECONDS", 0.05)
    operator, first, second = Operator(controller), Replies(), Replies()
    operator.submit(ARM, first)
    while not controller.asked:
        time.sleep(0.005)
    operator.submit(ARM, second)
    time.sleep(0.1)
    controller.free.set()
    assert first.wait(1) == [(True, "done")]
    ((done, words),) = second.wait(1)
    assert not done
    assert "behind another request" in words
    assert controller.asked == [ControlAction.ARM]
    assert operator.last_refusal == f"arm: {words}"


def test_more_requests_than_may_wait_are_refused_at_once(controller: Controller) -> None:
    operator, replies = Operator(controller), Replies()
    operator.submit(ARM, Replies())
    while not controller.asked:
        time.sleep(0.005)
    for _ in range(WAITING_MAX + 1):
        operator.submit(ARM, replies)
    assert replies.found == [(False, f"{WAITING_MAX} requests wait already: try again")]
    assert operator.refused == {"arm": 1}


def test_a_controller_that_does_not_reply_or_refuses_ends_no_thread() -> None:
    answers: list[ControlReply | BusError] = [
        BusError("no controller"),
        ControlReply(done=False, message="no pose yet"),
    ]

    def ask(_: ControlRequest) -> ControlReply:
        answer = answers.pop(0)
        if isinstance(answer, BusError):
            raise answer
        return answer

    operator, replies = Operator(ask), Replies()
    operator.submit(ARM, replies)
    operator.submit(ARM, replies)
    assert replies.wait(2) == [(False, "no controller"), (False, "no pose yet")]
    assert operator.refused == {"arm": 2}
