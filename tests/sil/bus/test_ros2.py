"""`tendond bridge ros2` among nodes that speak as rmw_zenoh does; the router is a Zenoh session on its own port."""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tendond.schemas.health import FilterHealth
from tendond.schemas.keys import STATUS, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import Message, Mode, TendonCommand, TendonState, TipPose
from tendond.schemas.requests import ControlAction
from tendond.schemas.wire import encode
from tests.sil.bus.live import Live
from tests.sil.bus.ros_peer import RosPeer, free_endpoint, opened, until
from tests.sil.rig import Rig, rig
from tests.unit.cli.test_watch import status

pytestmark = pytest.mark.sil

DOMAIN = 7
POSE, POINT = "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PointStamped"
PLACE = (0.25, 0.0, -0.0700182)
"""Where the paper's arm can rest [m]: what `tendond rig reference across=0.25` answers."""

DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"


@dataclass
class Bus:
    """A rig's bus without a controller: what is published is the test's."""

    rig: Rig
    session: zenoh.Session
    peer: RosPeer

    def put(self, name: str, message: Message) -> None:
        self.session.put(key(self.rig.name, name), encode(message))


@pytest.fixture(scope="module")
def router() -> Iterator[str]:
    endpoint = free_endpoint()
    with opened("router", listen=endpoint):
        yield endpoint


@pytest.fixture(scope="module")
def bus(router: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bus]:
    with rig(tmp_path_factory.mktemp("ros2")) as one:
        with opened("peer", listen=one.endpoint) as session:
            one.start("bridge", "ros2", "--router", router, "--domain", str(DOMAIN))
            peer = RosPeer(router, DOMAIN)
            with peer.session:
                until(lambda: any("%robot_description" in token for token in peer.tokens()))
                until(lambda: len(peer.tokens()) == 16)
                yield Bus(one, session, peer)
        _, said = one.end(one.started["bridge"])
        assert "Traceback" not in said


def reasons(heard: list[Any]) -> list[str]:
    """What the bridge's health said, of all diagnostics heard."""
    return [one.message for message, _ in list(heard) for one in message.status if one.name.endswith(": bridge")]


def test_ros_sees_a_node_with_the_rigs_topics_and_services(bus: Bus) -> None:
    """As `ros2 node list`, `ros2 topic list -t` and `ros2 service list -t` get them: from tokens."""
    seen = {
        (kind, topic.replace("%", "/"), kind_name)
        for kind, enclave, namespace, node, topic, kind_name, *_ in (
            token.split("/") for token in bus.peer.tokens() if token.count("/") > 3
        )
        if (enclave, namespace, node) == ("%", "%sil", "tendond")
    }
    assert "NN/%/%sil/tendond" in bus.peer.tokens()
    joints, trigger = "sensor_msgs::msg::dds_::JointState_", "std_srvs::srv::dds_::Trigger_"
    assert seen == {
        ("MP", "/sil/tip/pose", "geometry_msgs::msg::dds_::PoseStamped_"),
        ("MP", "/sil/tip/estimate", "geometry_msgs::msg::dds_::PoseWithCovarianceStamped_"),
        ("MP", "/sil/tendon/state", joints),
        ("MP", "/sil/tendon/command", joints),
        ("MP", "/sil/reference", "geometry_msgs::msg::dds_::PointStamped_"),
        ("MP", "/sil/rod", "visualization_msgs::msg::dds_::MarkerArray_"),
        ("MP", "/tf", "tf2_msgs::msg::dds_::TFMessage_"),
        ("MP", "/diagnostics", "diagnostic_msgs::msg::dds_::DiagnosticArray_"),
        ("MP", "/robot_description", "std_msgs::msg::dds_::String_"),
        ("MS", "/sil/goal_point", "geometry_msgs::msg::dds_::PointStamped_"),
        ("MS", "/sil/goal_pose", "geometry_msgs::msg::dds_::PoseStamped_"),
        *(("SS", f"/sil/{name}", trigger) for name in ("arm", "stop", "reset", "status")),
    }
    latched = [token for token in bus.peer.tokens() if "%robot_description" in token]
    assert latched[0].endswith("/:1:,1:,:,:,,"), "transient local, depth 1"


def test_what_is_on_the_bus_arrives_in_ros_with_wall_clock_stamps(bus: Bus) -> None:
    poses = bus.peer.echo("/sil/tip/pose", POSE)
    joints = bus.peer.echo("/sil/tendon/state", "sensor_msgs/msg/JointState")
    commands = bus.peer.echo("/sil/tendon/command", "sensor_msgs/msg/JointState")
    frames = bus.peer.echo("/tf", "tf2_msgs/msg/TFMessage")
    rods = bus.peer.echo("/sil/rod", "visualization_msgs/msg/MarkerArray")
    pose = TipPose(seq=1, stamp_ns=0, position=(0.1, -0.2, 0.3), orientation=(0.6, 0.8, 0.0, 0.0))
    four = (0.001, 0.0, -0.001, 0.0)
    taken = 0

    def sent() -> bool:
        nonlocal taken
        taken = time.time_ns()
        bus.put(TIP_POSE, pose.stamped(time.monotonic_ns()))
        bus.put(TIP_POSE, TipPose(**{**pose.__dict__, "valid": False, "position": (9.0, 9.0, 9.0)}))
        bus.put(TENDON_STATE, TendonState(seq=1, stamp_ns=time.monotonic_ns(), displacement=four, tension=(1.0,) * 4))
        bus.put(TENDON_COMMAND, TendonCommand(
            seq=1, stamp_ns=time.monotonic_ns(), pose_seq=1, displacement=four, tension=(5.0, 0.5, 0.5, 0.5), armed=True
        ))  # fmt: skip
        return len(poses) > 2 and len(joints) > 2 and len(commands) > 2 and len(frames) > 2 and len(rods) > 2

    until(sent)
    for message, (_, stamp, _) in poses:
        at, turn = message.pose.position, message.pose.orientation
        assert ((at.x, at.y, at.z), (turn.w, turn.x, turn.y, turn.z)) == (pose.position, pose.orientation)
        assert message.header.frame_id == "sil_base"
        assert abs(stamp - (message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec)) < 1e9
    heads = [head for _, head in poses]
    assert [head[0] for head in heads] == list(range(heads[0][0], heads[0][0] + len(heads))), "none lost, none twice"
    assert len({head[2] for head in heads}) == 1
    assert heads[0][2] not in {head[2] for _, head in joints}, "one identity per publisher"
    assert tuple(joints[0][0].position) == four
    assert tuple(commands[0][0].effort) == (5.0, 0.5, 0.5, 0.5)
    assert {one.child_frame_id for message, _ in frames for one in message.transforms} == {"sil_tip", "sil_tip_model"}
    line = until(lambda: next((m for m in reversed(rods[-1][0].markers) if m.ns == "rod" and m.points[-1].x > 0.01), 0))
    length = sum(
        math.dist((a.x, a.y, a.z), (b.x, b.y, b.z)) for a, b in zip(line.points, line.points[1:], strict=False)
    )
    assert length == pytest.approx(0.5, rel=0.01), "the rod under 5 N is bent, not longer"


def test_who_comes_late_gets_the_description_of_the_robot(bus: Bus) -> None:
    heard = bus.peer.echo("/robot_description", "std_msgs/msg/String", latched=True)
    text = until(lambda: heard and heard[0][0].data)
    assert '<link name="sil_tip">' in text


def test_health_and_estimate_come_from_the_controllers_status(bus: Bus) -> None:
    heard = bus.peer.echo("/diagnostics", DIAGNOSTICS)
    estimates = bus.peer.echo("/sil/tip/estimate", "geometry_msgs/msg/PoseWithCovarianceStamped")
    known = FilterHealth(
        force=0.1, force_deviation=0.1, tip_bound=0.1, stiffness=1.0, stiffness_deviation=0.1, consistency=1.0,
        tip=(0.1, 0.2, 0.3), tip_orientation=(1.0, 0.0, 0.0, 0.0), tip_covariance=(1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
    )  # fmt: skip

    def levels() -> set[tuple[int, str]]:
        found = [one for message, _ in list(heard) for one in message.status if one.name == "tendond sil: controller"]
        return {(int(one.level), one.message) for one in found}

    fault = status(Mode.FAULT, "pose lost").model_copy(
        update={"rig": "sil", "filter": known, "tension_estimate": (1.0,) * 4}
    )

    def faulty() -> bool:
        bus.put(STATUS, fault.stamped(time.monotonic_ns()))
        return (2, "fault: pose lost") in levels() and bool(estimates)

    until(faulty)
    assert list(estimates[0][0].pose.covariance[:3]) == [1.0, 2.0, 3.0]
    assert list(estimates[0][0].pose.covariance[6:9]) == [2.0, 4.0, 5.0]
    until(lambda: any(level == 3 and "no status for" in words for level, words in levels()))


def test_calls_without_a_controller_say_so_and_do_not_hang(bus: Bus) -> None:
    done, words = bus.peer.call("/sil/arm")
    assert not done
    assert words.startswith("no controller of rig 'sil' replies")


GOAL_FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "old": ({"age": 5.0}, "5.0 s old"),
    "unstamped": ({"stamp": 0}, "has no stamp"),
    "future": ({"age": -5.0}, "ahead of this host's clock"),
    "frame": ({"frame": "map"}, "is in frame 'map': give it in 'sil_base'"),
    "nan": ({"position": (math.nan, 0.0, 0.4)}, "is not finite"),
    "infinite": ({"position": (0.0, 0.0, math.inf)}, "is not finite"),
    "millimetres": ({"position": (100.0, 0.0, 400.0)}, "lengths are in metres: did you mean 0.4?"),
}


def goal(
    peer: RosPeer, position: Any = (0.1, 0.0, 0.4), age: float = 0.0, frame: str = "sil_base", stamp: int = 1
) -> bytes:
    types = peer.store.types
    sec, nanosec = divmod((time.time_ns() - round(1e9 * age)) * stamp, 1_000_000_000)
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](sec, nanosec), frame)
    return bytes(peer.store.serialize_cdr(types[POINT](header, types["geometry_msgs/msg/Point"](*position)), POINT))


@pytest.mark.parametrize("name", [*GOAL_FAULTS, "malformed", "cut"])
def test_a_wrong_goal_is_refused_with_its_reason_and_asks_nothing_of_the_controller(bus: Bus, name: str) -> None:
    asked: list[str] = []
    heard = bus.peer.echo("/diagnostics", DIAGNOSTICS)
    with bus.session.declare_queryable("sil/control/*", lambda query: asked.append(str(query.key_expr))):
        change, words = GOAL_FAULTS.get(name, ({}, "is malformed"))
        payload = b"{}" if name == "malformed" else goal(bus.peer, **change)
        bus.peer.publish("/sil/goal_point", POINT, payload[:-9] if name == "cut" else payload)
        until(lambda: any(words in reason for reason in reasons(heard)))
    assert not asked


def test_a_bridge_without_a_router_ends_with_a_line(tmp_path: Path) -> None:
    one = Rig(tmp_path)
    ended = one.command("bridge", "ros2", "--router", free_endpoint())
    assert ended.returncode == 1
    assert "no Zenoh router at tcp/127.0.0.1" in ended.stderr
    assert "ros2 run rmw_zenoh_cpp rmw_zenohd" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_ros_arms_moves_and_stops_the_rig_as_an_operator_does(live: Live, router: str) -> None:
    bridge = live.rig.start("bridge", "ros2", "--router", router, "--domain", "9")
    peer = RosPeer(router, 9)
    with peer.session:
        until(lambda: len(peer.tokens()) == 16)
        heard = peer.echo("/diagnostics", DIAGNOSTICS)
        assert peer.call("/sil/status")[1].startswith("idle")
        done, words = peer.call("/sil/arm", age=3.0)
        assert not done
        assert "3.0 s old" in words
        done, words = peer.call("/sil/arm", payload=b"?")
        assert not done
        assert "malformed" in words
        assert live.rig.status(live.session).mode is Mode.IDLE
        until(lambda: any("malformed" in reason for reason in reasons(heard)))

        x, y, z = PLACE
        peer.publish("/sil/goal_point", POINT, goal(peer, PLACE))
        live.rig.until(live.session, lambda status: status.target == pytest.approx((x, y, z), abs=1e-3))
        peer.publish("/sil/goal_point", POINT, goal(peer, (x, y, z + 0.2)))
        until(lambda: any("what the rod can reach" in reason for reason in reasons(heard)))
        assert live.rig.status(live.session).target == pytest.approx((x, y, z), abs=1e-3)
        until(lambda: peer.call("/sil/arm")[0])
        until(lambda: live.rig.status(live.session).mode is Mode.TRACKING)
        again = peer.call("/sil/arm")
        assert again == (False, live.rig.ask(live.session, ControlAction.ARM).message)
        assert peer.call("/sil/stop", payload=b"?", age=60.0)[0], "a stop is never refused"
        live.rig.until(live.session, lambda status: status.mode is Mode.IDLE)
    assert live.rig.end(bridge)[0] == 0
