"""References of poses: what they ask for, whether it can be reached, and how fast."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.pose.plan import follows_poses, plan_poses
from tendond.daemon.control.pose.pose import turn
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.task import led_pose
from tendond.daemon.errors import TargetError
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.rig import ConfigError
from tests.unit.pose.robots import TWO, config_of, rests

POSE: dict[str, Any] = {"kind": "pose", "position": [0.06, 0.02, 0.235], "duration": 1.0}
PATH: dict[str, Any] = {
    "kind": "path",
    "waypoints": [[0.06, 0.02, 0.235], [0.06, -0.02, 0.235], [0.04, -0.05, 0.235]],
    "duration": 1.0,
}


def planned(reference: dict[str, Any], **more: Any) -> PoseReference:
    config = config_of(TWO, reference, **more)
    return plan_poses(config, model_rod(config))


def test_a_position_is_approached_from_the_pretension_with_the_least_tension() -> None:
    reference = planned(POSE)
    assert reference.counts == "position"
    assert np.allclose(reference.at(99.0).position, POSE["position"], atol=2e-5)
    begin, end = reference.pose(0.0), reference.pose(99.0)
    assert np.allclose(begin.tension, 1.0)
    assert end.tension.min() >= 1.0 - 1e-6
    assert np.allclose(end.displacement_rate, 0.0)
    assert reference.notes == () or "takes" in reference.notes[0]


def test_a_pose_out_of_reach_is_refused_with_the_nearest_in_millimetres_and_degrees() -> None:
    wanted = {**POSE, "direction": [-1.0, 0.0, 0.2], "moved_max": 0.001, "turned_max": 0.05}
    with pytest.raises(
        TargetError, match=r"mm and .* degrees from where the tip can rest; the nearest reachable pose"
    ) as e:
        planned(wanted)
    assert "\n" not in str(e.value)
    assert "tilt of" in str(e.value)


def test_the_nearest_pose_is_taken_where_it_is_near_enough_and_that_is_said() -> None:
    reference = planned({**POSE, "direction": [0.35, 0.1, 0.9], "moved_max": 0.05, "turned_max": 0.8})
    assert reference.counts == "direction"
    assert "moved by up to" in reference.notes[0]
    assert 0.0 < reference.moved.distance <= 0.05


def test_a_path_of_directions_is_followed_where_the_robot_has_rests() -> None:
    some = rests("two")
    rows = []
    rest = some.rest(some.preferred)
    for pull in np.linspace(0.0, 1.2, 5):
        tension = some.preferred.copy()
        tension[0], tension[4] = 1.0 + pull, 1.0 + 0.5 * pull
        rest = some.rest(tension, rest.state)
        rows.append([*rest.pose.position.tolist(), *rest.pose.direction.tolist()])
    reference = planned({"kind": "path", "waypoints": rows, "duration": 1.0})
    assert reference.moved.distance < 2e-3
    assert reference.moved.angle < math.radians(1.0)
    there = reference.pose(reference.arrival).pose
    assert np.allclose(there.position, rows[-1][:3], atol=1e-3)
    assert np.allclose(there.direction, rows[-1][3:], atol=0.01)


def test_optimal_timing_keeps_every_limit_and_is_faster_than_a_slow_one() -> None:
    limits = {"tension_max": 20.0, "displacement_rate": 0.05, "tension_rate": 8.0}
    reference = planned({**PATH, "timing": "optimal", "speed_max": 0.12}, limits=limits)
    slow = planned({**PATH, "duration": 20.0}, limits=limits)
    assert reference.arrival < 0.5 * slow.arrival
    times = np.linspace(0.0, reference.arrival, 800)
    goals = [reference.pose(float(time)) for time in times]
    assert max(float(np.linalg.norm(goal.velocity)) for goal in goals) < 0.12 * 1.02
    assert max(float(np.abs(goal.displacement_rate).max()) for goal in goals) < 0.05
    tension = np.array([goal.tension for goal in goals])
    assert np.abs(np.diff(tension, axis=0)).max() / times[1] < 8.0


def test_a_path_that_is_asked_too_fast_is_slowed_and_the_limit_named() -> None:
    reference = planned({**PATH, "duration": 0.1}, limits={"tension_max": 20.0, "tension_rate": 10.0})
    assert any("limits.tension_rate" in note for note in reference.notes)


def test_only_poses_and_robots_of_sections_are_planned_as_poses() -> None:
    circle = {"kind": "circle", "radius": 0.05}
    assert follows_poses(config_of(TWO, circle), config_of(TWO, circle).reference)
    one = config_of({}, circle)
    assert not follows_poses(one, one.reference)
    tilted = config_of(TWO, {**circle, "aim": "direction", "radius": 0.3})
    assert not follows_poses(tilted, tilted.reference)


@pytest.mark.parametrize(
    ("reference", "says"),
    [
        ({"kind": "pose"}, "needs a position"),
        ({"kind": "pose", "position": [0, 0, 0.2], "direction": [0, 0, 1], "orientation": [1, 0, 0, 0]}, "one of them"),
        ({"kind": "pose", "position": [0, 0, 0.2], "orientation": [1, 1, 0, 0]}, "unit quaternion"),
        ({"kind": "path", "waypoints": [[0, 0, 0.2]]}, "two waypoints or more"),
        ({"kind": "path", "waypoints": [[0, 0, 0.2], [0, 0, 0.2, 1]]}, "all have 3 numbers"),
        ({"kind": "circle", "orientation": [1, 0, 0, 0]}, "orientation goes with kind = 'pose'"),
        ({"kind": "samples", "samples": [[0, 0, 0, 0, 0], [1, 0, 0, 0, 0]]}, "with a direction seven"),
    ],
)
def test_a_reference_that_is_none_is_refused_in_one_line(reference: dict[str, Any], says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        config_of(TWO, reference)


def test_the_lead_is_the_bend_by_the_acceleration_and_none_at_rest() -> None:
    reference = planned(PATH)
    end = led_pose(reference, reference.arrival + 1.0, 20.0, 1e-3)
    assert np.allclose(end.position, reference.pose(reference.arrival + 1.0).pose.position, atol=1e-9)
    time = reference.approach_time + 0.3
    goal, led = reference.pose(time), led_pose(reference, time, 20.0, 0.0)
    assert np.allclose(led.position - goal.pose.position, goal.acceleration / 400.0)
    assert np.linalg.norm(goal.acceleration) > 0.01
    assert 0.0 < np.linalg.norm(turn(goal.pose, led, "pose")) < 0.1
