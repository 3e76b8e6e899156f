"""Rights on a guarded bus."""

import os
import time
from contextlib import suppress
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import OUR_QUEUE, QUEUE_SIZE, BusError, client_config, open_client
from tendond.bus.operator import ask
from tendond.daemon.runtime.bus import Hub
from tendond.schemas.config.rig import ConfigError, check_config
from tendond.schemas.keys import SERVO_RESET, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key, sensor_topic
from tendond.schemas.messages import SensorReading, TendonCommand, TipPose
from tendond.schemas.requests import ControlAction, ControlReply
from tendond.schemas.wire import encode
from tests.sil.bus.guarded import POSE, STATE, Guarded, certificates, gets, put_in_place, until
from tests.sil.rig import flooded, rig

pytestmark = pytest.mark.sil


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_the_operator_may_reset_the_servos_and_a_viewer_may_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, protocol: str
) -> None:
    guarded = Guarded(tmp_path, monkeypatch, protocol)
    if protocol == "tls":
        certificates(tmp_path, ("controller", "servo", "operator", "viewer"))
    name = key("sil", SERVO_RESET)
    with (
        guarded.hub(),
        guarded.session("servo") as driver,
        guarded.session("operator") as operator,
        guarded.session("viewer") as viewer,
    ):

        def reply(query: zenoh.Query) -> None:
            query.reply(name, encode(ControlReply(done=True, message="the fault is reset")))

        driver.declare_queryable(name, reply)

        def has_reply(session: zenoh.Session) -> bool:
            return any(reply.ok is not None for reply in session.get(name, timeout=1.0))

        until(lambda: has_reply(operator))
        assert not has_reply(viewer)


@pytest.mark.parametrize("protocol", ["tcp", "tls"])
def test_only_the_camera_may_publish_poses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, protocol: str) -> None:
    guarded = Guarded(tmp_path, monkeypatch, protocol)
    if protocol == "tls":
        certificates(tmp_path)
    with guarded.hub() as hub, guarded.session("viewer") as viewer, guarded.session("vicon") as vicon:
        viewer.put(key("sil", TIP_POSE), encode(POSE.model_copy(update={"seq": 7})))
        vicon.put(key("sil", TENDON_STATE), encode(STATE))
        poses: list[TipPose] = []

        def good_one_arrives() -> bool:
            vicon.put(key("sil", TIP_POSE), encode(POSE))
            arrivals = hub.receive()
            assert arrivals.tendon_state is None
            assert not arrivals.unreadable or set(arrivals.unreadable) == {"out of order"}
            if arrivals.pose:
                poses.append(arrivals.pose)
            return bool(poses)

        until(good_one_arrives)
        for _ in range(20):
            viewer.put(key("sil", TIP_POSE), encode(POSE.model_copy(update={"seq": 7})))
            time.sleep(0.01)
            if (pose := hub.receive().pose) is not None:
                poses.append(pose)
        assert {pose.seq for pose in poses} == {1}


def test_only_the_drivers_of_sensors_may_publish_readings_and_a_viewer_hears_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    guarded = Guarded(tmp_path, monkeypatch)
    skin, pose = key("sil", sensor_topic("skin")), key("sil", TIP_POSE)
    reading = SensorReading(seq=1, stamp_ns=0, rows=((0.0, 0.0, 0.1),))
    section = {"name": "skin", "kind": "markers", "at": [0.1], "noise": 1e-3}
    with (
        guarded.hub(sensors=[section]) as hub,
        guarded.session("sensor") as driver,
        guarded.session("vicon") as vicon,
        guarded.session("viewer") as viewer,
    ):
        hears = viewer.declare_subscriber(skin, zenoh.handlers.FifoChannel(1000))
        found: list[int] = []
        heard: list[bytes] = []

        def good_one_arrives() -> bool:
            vicon.put(skin, encode(reading.model_copy(update={"seq": 7})))
            driver.put(pose, encode(POSE))
            driver.put(skin, encode(reading))
            arrivals = hub.receive()
            assert arrivals.pose is None
            found.extend(one.seq for one in arrivals.readings.values())
            while (sample := hears.try_recv()) is not None:
                heard.append(sample.payload.to_bytes())
            return len(found) > 10 and len(heard) > 10

        until(good_one_arrives)
        assert set(found) == {1}
        assert set(heard) == {encode(reading)}


def test_only_the_servo_driver_hears_commands_and_nobody_else_may_give_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    guarded = Guarded(tmp_path, monkeypatch)
    topic = key("sil", TENDON_COMMAND)
    with guarded.hub() as hub, guarded.session("servo") as servo, guarded.session("operator") as operator:
        hears = servo.declare_subscriber(topic, zenoh.handlers.FifoChannel(100))
        overhears = operator.declare_subscriber(topic, zenoh.handlers.FifoChannel(100))
        zeros = (0.0,) * 4
        command = TendonCommand(seq=5, stamp_ns=0, pose_seq=None, displacement=zeros, tension=zeros, armed=False)
        got: list[bytes] = []

        def real_one_arrives() -> bool:
            operator.put(topic, encode(command.model_copy(update={"armed": True})))
            hub.publish_command(command)
            while (sample := hears.try_recv()) is not None:
                got.append(sample.payload.to_bytes())
            return len(got) > 20

        until(real_one_arrives)
        assert set(got) == {encode(command.named(hub.source))}
        own = []  # a session hears what it publishes itself
        while (sample := overhears.try_recv()) is not None:
            own.append(sample.payload.to_bytes())
        assert encode(command) not in own


def test_only_the_operator_may_request_and_a_viewer_may_ask_for_the_status(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    guarded = Guarded(tmp_path, monkeypatch)
    with guarded.hub() as hub, guarded.session("operator") as operator, guarded.session("viewer") as viewer:
        assert gets(hub, operator, ControlAction.ARM)
        assert gets(hub, viewer, ControlAction.STATUS)
        assert not gets(hub, viewer, ControlAction.ARM)


def test_a_stop_is_heard_while_a_viewer_floods_a_guarded_bus_with_questions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    put_in_place(tmp_path)

    def become(name: str) -> None:
        monkeypatch.setenv("ZENOH_CONFIG", str(tmp_path / f"{name}.json5"))

    with rig(tmp_path) as one:
        become("controller")
        controller = one.controller()
        become("simulator")
        one.start("simulate")
        become("operator")
        with one.session() as operator:
            become("viewer")
            with one.session() as viewer:
                one.until(operator, lambda status: status.tip is not None)
                one.arm(operator)
                with flooded(one, viewer) as put:
                    first = ask(operator, "sil", ControlAction.STOP)
                    assert first.done
                    assert "releasing" in first.message
                    for _ in range(14):
                        asked = time.monotonic()
                        assert ask(operator, "sil", ControlAction.STOP).done
                        assert time.monotonic() - asked < 1.0
                        time.sleep(0.1)
                    with suppress(BusError):  # a viewer's own stop is not heard, flood or not
                        assert not ask(viewer, "sil", ControlAction.STOP).done
                    assert put[0] > 500
        assert one.end(controller)[0] == 0


def test_without_credentials_there_is_no_session_and_the_message_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    guarded = Guarded(tmp_path, monkeypatch)
    (tmp_path / "thief.json5").write_text((tmp_path / "operator.json5").read_text().replace("change-me", "guess"))
    with guarded.hub():
        with pytest.raises(BusError, match=r"or the credentials in .*thief\.json5"):
            guarded.session("thief", timeout=0.1)
        monkeypatch.delenv("ZENOH_CONFIG")
        with pytest.raises(BusError, match="no controller at"):
            open_client(guarded.endpoint, 0.1)


def test_an_open_bus_on_a_network_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ZENOH_CONFIG", raising=False)
    with pytest.raises(ConfigError, match="has no access list"):
        Hub(check_config({"bus": {"endpoint": "tcp/0.0.0.0:7447"}}, "test"))
    assert "ZENOH_CONFIG" not in os.environ


@pytest.mark.parametrize("endpoint", ["tcp/127.0.0.1:1", "tcp/localhost:1", "tcp/[::1]:1", "tcp/127.9.9.9:1"])
def test_loopback_needs_no_access_list(endpoint: str) -> None:
    assert check_config({"bus": {"endpoint": endpoint}}, "test").bus.is_loopback


def test_drivers_get_a_longer_queue_unless_the_file_chooses_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("ZENOH_CONFIG", raising=False)
    assert client_config("tcp/127.0.0.1:7447").get_json(QUEUE_SIZE) == str(OUR_QUEUE)
    file = tmp_path / "own.json5"
    file.write_text("{transport: {link: {tx: {queue: {size: {data: 5}}}}}}")
    monkeypatch.setenv("ZENOH_CONFIG", str(file))
    assert client_config("tcp/127.0.0.1:7447").get_json(QUEUE_SIZE) == "5"
