"""From Tracker's angles and millimetres to the rod's frame; SciPy's rotations are the reference."""

import itertools
import math
from typing import get_args

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.drivers.vicon.frames import Frame, Sequencer
from tendond.drivers.vicon.geometry import (
    Alignment,
    Placement,
    axes_matrix,
    continued,
    euler_from_rotation,
    rotation_from_euler,
    rotation_from_quaternion,
)
from tendond.drivers.vicon.poses import PoseBuilder
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config_vicon import Axes, EulerOrder, ViconSection
from tendond.schemas.ranges import Axis

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


def test_a_tip_seen_from_the_base_does_not_depend_on_where_the_world_is() -> None:
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
    seen = Alignment(section, GRAVITY).tip_in_base(tip, base)
    assert np.allclose(seen.position, [0.02, 0.0, 0.4], atol=1e-12)


def test_every_choice_of_axes_is_a_rotation_or_refused() -> None:
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
def test_markers_are_placed_so_that_the_driver_sees_what_they_were_placed_for(up: Axis) -> None:
    section = ViconSection(
        base_axes=("+z", "+x", "+y"), base_offset=(0.1, 0.0, 0.2), tip_axes=("+y", "-x", "+z"), up=up
    )
    alignment = Alignment(section, GRAVITY)
    truth = random_placement(4)
    tip, base = alignment.markers(truth)
    seen = alignment.tip_in_base(tip, base)
    assert np.allclose(seen.position, truth.position, atol=1e-12)
    assert np.allclose(seen.rotation, truth.rotation, atol=1e-12)
    assert alignment.gravity_error(base) == pytest.approx(0.0, abs=1e-7)


def test_the_quaternions_sign_does_not_jump_through_half_a_turn() -> None:
    last: Quaternion | None = None
    quaternions = []
    for angle in np.linspace(0.0, 4.0 * math.pi, 200):
        last = continued(rotation_from_euler((0.0, float(angle), 0.0), "XYZ"), last)
        quaternions.append(np.array(last))
    assert max(np.linalg.norm(b - a) for a, b in itertools.pairwise(quaternions)) < 0.05


def frame(number: int, **objects: Placement | None) -> Frame:
    return Frame(number, objects, number)


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


def test_a_hidden_tip_repeats_the_last_pose_as_invalid_and_names_the_object() -> None:
    builder = PoseBuilder(ViconSection(base="", base_axes=("+z", "+x", "+y"), latency=1e-6), GRAVITY)
    assert builder.build(frame(1, tip=None)) is None
    seen = builder.build(frame(2000, tip=PLACE))
    hidden = builder.build(frame(3000, tip=None))
    assert builder.objections == ("'tip' hidden",)
    missing = builder.build(frame(4000))
    assert builder.objections == ("'tip' not in the stream",)
    assert seen is not None
    assert hidden is not None
    assert missing is not None
    assert (seen.valid, hidden.valid, missing.valid) == (True, False, False)
    assert seen.position == hidden.position == missing.position
    assert [pose.seq for pose in (seen, hidden, missing)] == [0, 1, 2]
    assert [pose.stamp_ns for pose in (seen, hidden, missing)] == [1000, 2000, 3000]
