"""Poses of tags in rendered pictures, whose placements are known; the renderer follows single rays."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tendond.drivers.apriltag.detector import TagDetector, draw
from tendond.drivers.apriltag.edges import refined
from tendond.drivers.apriltag.pose import TagPose, angle, solutions
from tendond.drivers.mocap.geometry import Placement
from tests.rig.mocap.pictures import CAMERA, facing, render, tag

SIZE = 0.03


def corners_in(picture: np.ndarray, number: int = 0) -> np.ndarray:
    (found,) = TagDetector("36h11").find(picture)[number]
    corners = refined(picture, found, CAMERA)
    assert corners is not None
    return corners


@pytest.mark.parametrize(
    ("at", "bound", "turn_bound"),
    [
        (facing(0.02, -0.01, 0.2, (0.5, 0.3, 0.2)), 0.3e-3, 0.5),
        (facing(-0.06, 0.05, 0.3, (0.0, -0.9, 1.5)), 0.6e-3, 0.5),
        (facing(0.03, 0.03, 0.5, (0.6, 0.6, -0.4)), 2e-3, 1.5),
        (facing(0.15, -0.1, 0.5, (-0.7, 0.2, 3.0)), 2e-3, 1.5),
    ],
    ids=["near", "tilted by 52 degrees", "half a metre", "at the edge of the picture"],
)
def test_a_tag_of_three_centimetres_is_where_it_was_put(at: Placement, bound: float, turn_bound: float) -> None:
    """Bounds [m] and [degrees]; the camera has a lens, and pictures blur and noise."""
    for seed in range(3):
        corners = corners_in(render([tag(0, SIZE, at)], seed=seed))
        found = solutions(corners, SIZE, CAMERA)[0]
        assert np.linalg.norm(found.placement.position - at.position) < bound
        assert math.degrees(angle(found.placement, at)) < turn_bound
        assert found.error < 0.2


def test_refined_corners_are_ten_times_better_than_the_detectors() -> None:
    at = facing(0.03, 0.03, 0.5, (0.6, 0.6, -0.4))
    picture = render([tag(0, SIZE, at)])
    (rough,) = TagDetector("36h11").find(picture)[0]
    off = [
        np.linalg.norm(solutions(c, SIZE, CAMERA)[0].placement.position - at.position)
        for c in (rough, corners_in(picture))
    ]
    assert off[1] < 0.1 * off[0]


def test_of_two_poses_that_project_alike_the_one_that_continues_is_taken() -> None:
    """Far away, single pictures prefer the mirrored pose now and then: a tag that turns slowly does not jump."""
    generator = np.random.default_rng(3)
    camera_matrix = np.array([[700.0, 0.0, 325.0], [0.0, 705.0, 236.0], [0.0, 0.0, 1.0]])
    half = 0.5 * SIZE
    square = np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])
    tracked, single = TagPose(CAMERA, SIZE), []
    jumps = []
    for count in range(100):
        at = facing(0.0, 0.0, 0.8, (0.45 - 0.002 * count, 0.1, 0.0))
        projected = (square @ at.rotation.T + at.position) @ camera_matrix.T
        corners = projected[:, :2] / projected[:, 2:] + generator.normal(0.0, 0.15, (4, 2))
        found = tracked.update(corners, 0.02 * count)
        assert found is not None
        jumps.append(math.degrees(angle(found.placement, at)) > 20.0)
        single.append(math.degrees(angle(solutions(corners, SIZE, CAMERA)[0].placement, at)) > 20.0)
    assert sum(single) > 5, "the pictures are not ambiguous"
    assert not any(jumps[10:]), (sum(jumps), sum(single))


def test_a_wrong_beginning_is_given_up_when_pictures_contradict_it() -> None:
    right, other = facing(0.0, 0.0, 0.25, (0.6, 0.0, 0.0)), facing(0.0, 0.0, 0.25, (-0.6, 0.0, 0.0))
    tracked = TagPose(CAMERA, SIZE)
    before = corners_in(render([tag(0, SIZE, other)]))
    after = corners_in(render([tag(0, SIZE, right)]))
    tracked.update(before, 0.0)
    found = [tracked.update(after, 0.02 * (count + 1)) for count in range(20)]
    assert found[-1] is not None
    assert math.degrees(angle(found[-1].placement, right)) < 1.0


def test_a_blurred_or_cut_tag_has_no_corners() -> None:
    picture = render([tag(0, SIZE, facing(0.0, 0.0, 0.3))])
    (rough,) = TagDetector("36h11").find(picture)[0]
    assert refined(np.full_like(picture, 128), rough, CAMERA) is None
    hidden = picture.copy()
    hidden[:, int(rough[:, 0].mean()) :] = 128
    assert 0 not in TagDetector("36h11").find(hidden)


def test_a_tag_that_a_family_does_not_have_is_refused() -> None:
    with pytest.raises(ValueError, match="tags 0 to 586"):
        draw("36h11", 587, 100)


def test_a_tag_is_drawn_as_the_family_publishes_it() -> None:
    """Code 0 of 36h11 by AprilTag 2's tag36h11.c (E. Olson), row by row from the top left: white where a bit is set."""
    code = 0xD5D628584
    published = np.zeros((8, 8), bool)
    published[1:7, 1:7] = np.array([code >> (35 - bit) & 1 for bit in range(36)]).reshape(6, 6)
    np.testing.assert_array_equal(draw("36h11", 0, 80)[5::10, 5::10] > 127, published)


def test_tags_frame_is_as_printed_x_right_y_up_z_out_of_the_paper() -> None:
    at = facing(0.0, 0.0, 0.3)
    found = solutions(corners_in(render([tag(0, SIZE, at)])), SIZE, CAMERA)[0].placement
    turned = Rotation.from_matrix(found.rotation) * Rotation.from_matrix(np.diag([1.0, -1.0, -1.0]))
    assert turned.magnitude() < 0.05
