"""The law 'sensitivity' on robots of sections, in lockstep."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.laws.sensitivity import Parameters, decide
from tendond.daemon.control.pose.goals import goal_at
from tendond.daemon.control.pose.pose import Pose, miss, rotation_to
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.task import PoseObservation, PoseTask
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.trials.sections import end_direction
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.unit.pose.robots import THREE, TWO, config_of


@pytest.mark.parametrize(
    ("rod", "reference"),
    [
        (TWO, {"position": [0.06, 0.02, 0.235]}),
        (THREE, {"position": [0.05, -0.02, 0.172], "direction": [0.45, -0.2, 0.87], "turned_max": 0.1}),
    ],
    ids=["two sections, position", "three sections, position and direction"],
)
def test_a_pose_is_reached_within_3_mm_and_2_degrees_and_no_tendon_is_slack(rod: Any, reference: Any) -> None:
    config = config_of(rod, {"kind": "pose", "duration": 1.2, **reference})
    wanted = CycleSetup.from_config(config).selection.reference
    assert isinstance(wanted, PoseReference)
    cycles = 20 + math.ceil((config.pretension.duration + wanted.arrival + 0.5) / config.loop.period)
    trace = list(watched_loop(config, cycles, {20: ControlAction.ARM}, points=60))
    tracked = [one for one in trace if one.record.mode is Mode.TRACKING]
    assert trace[-1].record.mode is Mode.TRACKING, trace[-1].record.reason
    distances, angles = [], []
    for k, one in enumerate(tracked):
        pose = Pose(np.array(one.truth.position), rotation_to(end_direction(one.shape)))
        apart = miss(pose, wanted.pose(k * config.loop.period).pose, "direction")
        distances.append(apart.distance)
        angles.append(math.degrees(apart.angle))
    assert np.sqrt(np.mean(np.square(distances))) < 3e-3
    assert np.sqrt(np.mean(np.square(angles))) < 2.0
    assert min(min(one.record.command.tension) for one in tracked) >= config.pretension.tension_min - 1e-9
    assert not any("not finite" in one.record.limited for one in tracked)


def test_without_a_rest_the_law_holds() -> None:
    config = config_of(TWO, {"kind": "pose", "position": [0.06, 0.02, 0.235]})
    task = CycleSetup.from_config(config).selection.task
    assert isinstance(task, PoseTask)
    goal = goal_at(task.reference, 0.5)
    tension = np.full(7, 1.5)
    observation = PoseObservation(
        pose=goal.pose, velocity=np.zeros(3), goal=goal, now=goal, preferred=tension, led=goal.pose, jumps=False,
        counts="position", radian=0.05, tension=tension, tension_min=1.0, tension_max=20.0,
        period=0.01, frequency=20.0, still=None,
    )  # fmt: skip
    assert decide(Parameters(), observation).tension.tolist() == tension.tolist()
