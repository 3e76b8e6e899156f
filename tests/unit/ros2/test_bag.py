"""A log exported as a bag is read by an independent reader of rosbag2, and says what the log says."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability

from tendond.cli.extras import install_command
from tendond.drivers.ros2.messages import RigMessages
from tendond.drivers.ros2.types import types_of
from tendond.offline.logs.log import load
from tendond.schemas.messages import Mode
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import few_lines, tendond

LOG = FOLDER / "faults.mcap"
Read = dict[str, list[tuple[int, Any]]]


def read(bag: Path) -> Read:
    """Every message of a bag, by topic, with its time [ns]; decoded by the definitions in the bag itself."""
    found: Read = {}
    with AnyReader([bag]) as reader:
        for connection, time_ns, data in reader.messages():
            found.setdefault(connection.topic, []).append((time_ns, reader.deserialize(data, connection.msgtype)))
    return found


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from tendond.offline.rosbag.export import export_bag

    path = tmp_path_factory.mktemp("bags") / "faults"
    export_bag(LOG, path, "jazzy")
    return path


def stamp(message: Any) -> int:
    return int(message.header.stamp.sec) * 1_000_000_000 + int(message.header.stamp.nanosec)


def test_a_bag_has_the_poses_tendons_and_frames_of_the_log(bag: Path) -> None:
    found, log = read(bag), load(LOG)
    name = log.config.rig.name
    poses = [record.inputs.pose for record in log.records if record.inputs.pose and record.inputs.pose.valid]
    measured = [message for _, message in found[f"/{name}/tip/pose"]]
    assert len(measured) == len(poses) > 10
    for pose, message in zip(poses, measured, strict=True):
        at, turn = message.pose.position, message.pose.orientation
        assert (at.x, at.y, at.z) == pose.position
        assert (turn.w, turn.x, turn.y, turn.z) == pose.orientation
        assert message.header.frame_id == f"{name}_base"
    commands = [message for _, message in found[f"/{name}/tendon/command"]]
    assert len(commands) == len(log.records)
    for record, message in zip(log.records, commands, strict=True):
        assert tuple(message.position) == record.command.displacement
        assert tuple(message.effort) == record.command.tension
        assert message.name == [f"tendon_{i}" for i in range(4)]
    states = [record.inputs.tendon_state for record in log.records if record.inputs.tendon_state]
    for state, (_, message) in zip(states, found[f"/{name}/tendon/state"], strict=True):
        assert tuple(message.position) == state.displacement
    frames = [{one.child_frame_id: one for one in message.transforms} for _, message in found["/tf"]]
    last = frames[-1][f"{name}_tip_model"].transform.translation
    assert (last.x, last.y, last.z) == log.records[-1].model.position


def test_a_bag_draws_the_rod_of_the_log_and_reports_its_faults(bag: Path) -> None:
    found, log = read(bag), load(LOG)
    shapes = [message.markers for _, message in found[f"/{log.config.rig.name}/rod"]]
    assert len(shapes) == len(log.shapes)
    for (_, points), tendons, markers in zip(log.shapes, log.tendons, shapes, strict=True):
        rod = next(marker for marker in markers if marker.ns == "rod")
        np.testing.assert_array_equal([(one.x, one.y, one.z) for one in rod.points], points)
        assert sum(marker.ns == "tendons" for marker in markers) == len(tendons)
    errors = [status for _, message in found["/diagnostics"] for status in message.status if status.level == 2]
    faults = {record.reason for record in log.records if record.mode is Mode.FAULT}
    assert faults
    assert {status.message for status in errors} == {f"fault: {reason}" for reason in faults}


def test_times_of_a_bag_are_the_wall_clocks(bag: Path) -> None:
    with LOG.open("rb") as stream:
        times = {message.log_time for _, _, message in make_reader(stream).iter_messages(["cycle"])}
    for topic, messages in read(bag).items():
        for time_ns, message in messages if topic != "/robot_description" else ():
            assert time_ns in times
            if hasattr(message, "header"):
                assert 0 <= time_ns - stamp(message) <= 1_000_000_000


def test_a_bag_is_one_of_ros_2_and_offers_the_description_to_those_who_come_late(bag: Path) -> None:
    with (bag / f"{bag.name}.mcap").open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
    assert summary is not None
    assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
    assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
    with AnyReader([bag]) as opened:
        durabilities = {one.topic: one.ext.offered_qos_profiles[0].durability for one in opened.connections}  # type: ignore[union-attr]  # a connection of rosbag1 has no such profiles
    assert durabilities.pop("/robot_description") is QosDurability.TRANSIENT_LOCAL
    assert set(durabilities.values()) == {QosDurability.VOLATILE}


def test_the_covariance_of_an_estimate_is_symmetric_and_says_that_the_turn_is_unknown() -> None:
    messages = RigMessages(types_of("jazzy"), "paper")
    found = messages.estimate(5, ((1.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0)), (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    again = types_of("jazzy").decode(found.__msgtype__, types_of("jazzy").encode(found))
    matrix = np.reshape(again.pose.covariance, (6, 6))
    np.testing.assert_array_equal(matrix[:3, :3], [[1, 2, 3], [2, 4, 5], [3, 5, 6]])
    np.testing.assert_array_equal(matrix, matrix.T)
    np.testing.assert_array_equal(np.diag(matrix)[3:], [np.pi**2] * 3)


def test_a_bag_is_not_written_over_another_nor_half(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "bag"
    assert tendond(capsys, "log", "export", "--rosbag2", str(LOG), "--out", str(out)).status == 0
    before = sorted(out.iterdir())
    for taken in (out, tmp_path / "bag.mcap", Path("/proc/no/such")):
        ended = tendond(capsys, "log", "export", "--rosbag2", str(LOG), "--out", str(taken))
        assert ended.status in (1, 2)
        assert str(taken) in ended.said
        assert few_lines(ended.said)
    assert sorted(out.iterdir()) == before
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(LOG.read_bytes()[:2000])
    assert tendond(capsys, "log", "export", "--rosbag2", str(cut), "--out", str(tmp_path / "none")).status == 2
    assert sorted(one.name for one in tmp_path.iterdir()) == ["bag", "cut.mcap"]


def test_an_unknown_distribution_is_refused_with_those_that_are_known(capsys: pytest.CaptureFixture[str]) -> None:
    ended = tendond(capsys, "log", "export", "--rosbag2", str(LOG), "--distro", "foxy")
    assert ended.status == 2
    assert "jazzy, kilted, rolling, humble" in ended.said
    assert install_command("ros2") == "pip install 'tendond[ros2]'"
