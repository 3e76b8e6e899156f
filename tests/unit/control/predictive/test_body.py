"""Limits of the body in the plan: with them the safety filter has less to alter, and the true arm stays clear."""

import numpy as np
import pytest

from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

CENTER, RADIUS, ARM = np.array([0.25, 0.01, 0.42]), 0.05, 0.02
"""A ball a little beside the way: of one straight in it a plan changes the side again and again (docs, mpc)."""

BALL = f"""
[[safety.obstacle]]
kind = "sphere"
center = {CENTER.tolist()}
radius = {RADIUS}
"""
RIG = """
[control]
law = "mpc"
[control.laws.mpc]
avoid = {avoid}
[pretension]
duration = 0.1
[reference]
kind = "point"
position = [0.25, 0.0, 0.401]
duration = 1.0
[simulator]
solver = "general"
[simulator.rod.scale]
stiffness = 0.93
[safety]
margin = 0.003
"""


def tracked(avoid: str, safety: str) -> list[Watched]:
    config = parse_config(RIG.format(avoid=avoid) + safety, "test")
    run = watched_loop(config, 75, {2: ControlAction.ARM}, 40)
    return [one for one in run if one.record.mode is Mode.TRACKING]


def altered(run: list[Watched]) -> float:
    return sum(one.record.safety.altered for one in run if one.record.safety is not None)


@pytest.mark.parametrize("safety", [BALL, "strain_max = 0.001\n"])
def test_a_plan_that_avoids_leaves_the_filter_less_to_do(safety: str) -> None:
    plain, avoiding = tracked("false", safety), tracked("true", safety)
    assert len(avoiding) == len(plain) > 40
    assert altered(plain) > 0.0
    assert altered(avoiding) < 0.2 * altered(plain)
    if safety == BALL:
        shapes = np.array([one.shape for one in avoiding])
        assert np.linalg.norm(shapes - CENTER, axis=2).min() - RADIUS >= ARM
