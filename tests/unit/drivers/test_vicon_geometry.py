"""Tracker's angles and millimetres, converted to the rod's frame; SciPy's rotations are the reference."""

import itertools
import math
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.drivers.mocap.frames import Frame, Sequencer
from tendond.drivers.mocap.geometry import (
    Alignment,
    Placement,
    axes_matrix,
    continued,
    euler_from_rotation,
    rotation_from_euler,
    rotation_from_quaternion,
)
from tendond.drivers.mocap.level import Level
from tendond.drivers.mocap.poses import PoseBuilder
from tendond.drivers.vicon.senders import Senders
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.ranges import Axis
from tendond.schemas.config.vicon import Axes, EulerOrder, ViconSection

ANGLES: Vector3 = (0.3, -1.1, 2.2)
GRAVITY: Vector3 = (-9.81, 0.0, 0.0)


def random_placement(seed: int) -> Placement:
    generator = np.random.default_rng(seed)
    return Placement(generator.normal(size=3), Rotation.random(random_state=seed).as_matrix())


@pytest.mark.parametrize("order", get_args(EulerOrder))
def test_every_euler_order_is_scipys(order: EulerOrder) -> None:
    angles = [ANGLES["XYZ".index(letter)] for letter in order.upper()]
    assert np.allclose(rotation_from_euler(ANGLES, order), Rotation.from_euler(order, angles).as_matrix(), atol=1e-14)


def test_euler_angles_and_quaternions_there_and_back() -> None:
    matrix = random_placement(1).rotation
    locked = Rotation.from_euler("XYZ", [0.3, math.pi / 2, 0.4]).as_matrix()
    for turned in (matrix, locked, locked.T):
        assert np.allclose(rotation_from_euler(euler_from_rotation(turned), "XYZ"), turned, atol=1e-7)
    assert np.allclose(rotation_from_quaternion(*continued(matrix, None)), matrix, atol=1e-12)
    with pytest.raises(ValueError, match="unit"):
        rotation_from_quaternion(1.0, 1.0, 0.0, 0.0)


def test_a_tip_relative_to_the_base_does_not_depend_on_where_the_world_is() -> None:
    section = ViconSection(base_axes=("+z", "+x", "+y"), base_offset=(0.01, 0.02, 0.03), tip_offset=(0.0, 0.0, -0.004))
    alignment = Alignment(section, GRAVITY)
    tip, base, moved = random_placement(1), random_placement(2), random_placement(3)
    here, there = alignment.tip_in_base(tip, base), alignment.tip_in_base(moved.after(tip), moved.after(base))
    assert np.allclose(here.position, there.position, atol=1e-12)
    assert np.allclose(here.rotation, there.rotation, atol=1e-12)


def test_axes_and_offsets_by_hand() -> None:
    """Base markers turned about their x: the rod stands along their -y. Its base is 10 mm further along +y."""
    section = ViconSection(base_axes=("+x", "+z", "-y"), base_offset=(0.0, 0.01, 0.0))
    base = Placement(np.array([1.0, 1.0, 1.0]), np.eye(3))
    tip = Placement(np.array([1.02, 0.61, 1.0]), np.eye(3))
    tip_pose = Alignment(section, GRAVITY).tip_in_base(tip, base)
    assert np.allclose(tip_pose.position, [0.02, 0.0, 0.4], atol=1e-12)


def test_every_selection_of_axes_is_a_rotation_or_refused() -> None:
    good = 0
    for axes in itertools.product(get_args(Axis), repeat=3):
        try:
            section = ViconSection(base_axes=axes)
        except ValueError:
            continue
        good += 1
        matrix = axes_matrix(section.base_axes)
        assert np.allclose(matrix @ matrix.T, np.eye(3))
        assert np.linalg.det(matrix) == pytest.approx(1.0)
    assert good == 24


def test_gravity_shows_a_base_that_is_mounted_differently_from_the_model() -> None:
    """The rod lies: its +x points up in the lab, so gravity is along -x, as the paper has it."""
    lying: Axes = ("+z", "+x", "+y")
    base = Placement(np.zeros(3), np.eye(3))
    assert Alignment(ViconSection(base_axes=lying), GRAVITY).gravity_error(base) == pytest.approx(0.0, abs=1e-7)
    assert Alignment(ViconSection(), GRAVITY).gravity_error(base) == pytest.approx(math.pi / 2)
    assert Alignment(ViconSection(base_axes=lying, up="+y"), GRAVITY).gravity_error(base) == pytest.approx(math.pi / 2)
    assert Alignment(ViconSection(), (0.0, 0.0, 0.0)).gravity_error(base) == 0.0


@pytest.mark.parametrize("up", get_args(Axis))
def test_markers_are_placed_so_that_the_driver_measures_the_intended_pose(up: Axis) -> None:
    section = ViconSection(
        base_axes=("+z", "+x", "+y"), base_offset=(0.1, 0.0, 0.2), tip_axes=("+y", "-x", "+z"), up=up
    )
    alignment = Alignment(section, GRAVITY)
    truth = random_placement(4)
    tip, base = alignment.markers(truth)
    tip_pose = alignment.tip_in_base(tip, base)
    assert np.allclose(tip_pose.position, truth.position, atol=1e-12)
    assert np.allclose(tip_pose.rotation, truth.rotation, atol=1e-12)
    assert alignment.gravity_error(base) == pytest.approx(0.0, abs=1e-7)


def test_the_quaternions_sign_does_not_jump_through_half_a_turn() -> None:
    last: Quaternion | None = None
    quaternions = []
    for angle in np.linspace(0.0, 4.0 * math.pi, 200):
        last = continued(rotation_from_euler((0.0, float(angle), 0.0), "XYZ"), last)
        quaternions.append(np.array(last))
    assert max(np.linalg.norm(b - a) for a, b in itertools.pairwise(quaternions)) < 0.05


def frame(number: int, seconds: float = 0.0, **objects: Placement | None) -> Frame:
    return Frame(number, objects, number + round(seconds * 1e9))


PLACE = Placement(np.zeros(3), np.eye(3))


def test_objects_of_one_frame_are_put_together_from_several_packets() -> None:
    one = Sequencer(frozenset({"tip", "base"}))
    assert one.add(frame(5, tip=PLACE)) == []
    (whole,) = one.add(frame(5, base=PLACE, other=PLACE))
    assert (whole.number, set(whole.objects)) == (5, {"tip", "base", "other"})
    assert one.add(frame(5, more=PLACE)) == []
    assert not one.counts


def test_a_frame_without_the_tip_is_given_out_when_the_next_begins() -> None:
    one = Sequencer(frozenset({"tip", "base"}))
    assert one.add(frame(5, base=PLACE)) == []
    first, second = one.add(frame(6, base=PLACE, tip=PLACE))
    assert (first.number, second.number) == (5, 6)
    assert "tip" not in first.objects


def test_gaps_duplicates_late_frames_and_restarts_are_counted() -> None:
    one = Sequencer(frozenset({"tip"}))
    given = [one.add(frame(number, tip=PLACE)) for number in (500, 501, 501, 505, 504, 3, 4)]
    assert [[f.number for f in frames] for frames in given] == [[500], [501], [], [505], [], [3], [4]]
    assert one.counts == {"frames lost": 3, "duplicate": 1, "late": 1, "restarts": 1}


def test_no_number_of_a_frame_makes_more_lost_frames_than_the_time_had_room_for() -> None:
    """A stray packet with a wild number, and back: neither is a gap of milliards of frames."""
    one = Sequencer(frozenset({"tip"}))
    for count, number in enumerate((500, 501, 2**32 - 5, 503, 3_000_000_000, 505)):
        assert [f.number for f in one.add(frame(number, seconds=0.01 * count, tip=PLACE))] == [number]
    assert one.counts == {"restarts": 4}


def test_frames_that_were_lost_in_a_long_silence_are_counted_as_such() -> None:
    one = Sequencer(frozenset({"tip"}))
    one.add(frame(500, tip=PLACE))
    one.add(frame(6500, seconds=60.0, tip=PLACE))
    assert one.counts == {"frames lost": 5999}


def test_the_number_of_a_frame_begins_anew_after_four_bytes() -> None:
    one = Sequencer(frozenset({"tip"}))
    given = [one.add(frame(number, tip=PLACE)) for number in (2**32 - 2, 2**32 - 1, 0, 1)]
    assert [[f.number for f in frames] for frames in given] == [[2**32 - 2], [2**32 - 1], [0], [1]]
    assert not one.counts


def rolled(degrees: float) -> Placement:
    """The base of a rod that lies, with its +x up, turned about the rod's own axis (the world's x)."""
    return Placement(np.zeros(3), Rotation.from_euler("x", degrees, degrees=True).as_matrix())


@pytest.mark.parametrize(("degrees", "said"), [(1.5, False), (-1.5, False), (2.5, True), (-9.0, True)])
def test_a_base_that_is_rolled_by_more_than_two_degrees_is_reported_with_the_gravity_that_fits(
    degrees: float, said: bool
) -> None:
    alignment = Alignment(ViconSection(base_axes=("+z", "+y", "-x")), GRAVITY)
    level = Level(alignment, GRAVITY)
    for _ in range(5):
        level.see(rolled(degrees))
    assert level.tilted is said
    assert math.degrees(level.tilt) == pytest.approx(abs(degrees), abs=1e-6)
    if said:
        fits = [float(text) for text in level.objection().rpartition("[")[2].rstrip("]").split(",")]
        assert Alignment(ViconSection(base_axes=("+z", "+y", "-x")), (fits[0], fits[1], fits[2])).gravity_error(
            rolled(degrees)
        ) == pytest.approx(0.0, abs=math.radians(0.05))
        assert f"turned by {abs(degrees):.1f} degrees" in level.objection()
    else:
        assert level.objection() == ""


def test_noise_about_the_limit_does_not_make_a_base_tilted_and_level_in_turn() -> None:
    generator = np.random.default_rng(1)
    level = Level(Alignment(ViconSection(base_axes=("+z", "+y", "-x")), GRAVITY), GRAVITY)
    changes = 0
    for angle in 2.0 + generator.normal(scale=0.5, size=2000):
        before = level.tilted
        level.see(rolled(float(angle)))
        changes += level.tilted != before
    assert changes <= 1


def test_the_first_sender_is_kept_until_it_falls_silent_and_others_are_named() -> None:
    senders = Senders("", patience=1.0)
    first, second = ("10.0.0.1", 4000), ("10.0.0.2", 5000)
    assert senders.admit(second, 0.0)  # nobody has shown the robot's objects yet
    assert senders.admit(first, 0.0)
    senders.keep(first, 0.0)
    assert not any(senders.admit(second, 0.1 * i) for i in range(10))
    assert senders.counts == {"of another sender": 10}
    assert senders.news == [
        "the robot's objects come from 10.0.0.1:4000",
        "packets of 10.0.0.2:5000 are passed over: 10.0.0.1:4000 sends the robot's objects, and was first",
    ]
    assert senders.admit(second, 1.5)
    senders.keep(second, 1.5)
    assert not senders.admit(first, 1.6)


def test_with_a_configured_sender_no_other_is_used_whatever_it_sends() -> None:
    senders = Senders("10.0.0.9", patience=1.0)
    for i in range(1000):
        assert not senders.admit((f"10.0.{i % 200}.2", 5000), float(i))
    assert len(senders.news) <= 8
    assert senders.admit(("10.0.0.9", 5000), 1000.0)


def test_a_hidden_tip_repeats_the_last_pose_as_invalid_and_names_the_object() -> None:
    builder = PoseBuilder(ViconSection(base="", base_axes=("+z", "+x", "+y"), latency=1e-6), GRAVITY)
    assert builder.build(frame(1, tip=None)) is None
    tip_pose = builder.build(frame(2000, tip=PLACE))
    hidden = builder.build(frame(3000, tip=None))
    assert builder.objections == ("'tip' hidden",)
    missing = builder.build(frame(4000))
    assert builder.objections == ("'tip' not in the stream",)
    assert tip_pose is not None
    assert hidden is not None
    assert missing is not None
    assert (tip_pose.valid, hidden.valid, missing.valid) == (True, False, False)
    assert tip_pose.position == hidden.position == missing.position
    assert [pose.seq for pose in (tip_pose, hidden, missing)] == [0, 1, 2]
    assert [pose.stamp_ns for pose in (tip_pose, hidden, missing)] == [1000, 2000, 3000]
