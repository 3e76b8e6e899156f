"""Blocks of a probe: averages that lack one pose, and the cycle that ends them."""

import dataclasses
from typing import Any

import numpy as np

from tendond.daemon.control.commissioning.averages import Average, RestWatch
from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.probe_advance import advance_probe
from tendond.daemon.control.commissioning.probe_plan import Phase, ProbePlan
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import TendonState, TipPose

LEVEL: Quaternion = (1.0, 0.0, 0.0, 0.0)
REST: Vector3 = (-0.03, 0.0, 0.5)
TEXT = """
[loop]
period = {period}
[rod]
tendon_positions = [[0.01, 0.0], [0.0, 0.02], [-0.02, 0.0], [0.0, -0.02]]
[commissioning]
motion = 0.02
ramp = {ramp}
settling = {settling}
angle = 0.4
gain_min = 0.5
gain_max = 1.6
tension_fraction = 0.2
"""


def plan(period: float = 0.01, ramp: float = 0.2, settling: float = 1.0) -> ProbePlan:
    config = parse_config(TEXT.format(period=period, ramp=ramp, settling=settling), "test")
    return ProbePlan.from_config(config, rod_from_section(config.rod, period).parameters, None)


PLAN = plan()
FIRST_LOOK = PLAN.start + PLAN.ramp + PLAN.block
LAST_LOOK = PLAN.start + PLAN.ramp + PLAN.settling
EXPECTED = 0.01
ALLOWED = 0.15 * EXPECTED + 0.015 * PLAN.motion  # by which a settled tip may move in a block


def block(mean: Vector3, spread: float, count: int = PLAN.block - 1) -> Average:
    """A block that lacks one pose, at its mean."""
    x, y, z = mean
    return Average(
        count, (count * x, count * y, count * z), (float(count), 0.0, 0.0, 0.0), (x - spread / 2, y, z),
        (x + spread / 2, y, z),
    )  # fmt: skip


def at(x: float, y: float = 0.0) -> Vector3:
    return (REST[0] + x, REST[1] + y, REST[2])


STILL = RestWatch(5, average := block(REST, 0.0), average)
BASE = Probe(Phase.PULL, base=REST, model_base=REST, displacement=((0.0,) * 4, ()))


def end_block(
    probe: Probe, tip: Vector3 = REST, model: Vector3 = REST, *, spread: float = 0.0, model_spread: float = 0.0,
    watch: RestWatch = STILL, tendons: TendonState | None = None, displacement: tuple[float, ...] = (0.0,) * 4,
    use: ProbePlan = PLAN, **fields: Any,
) -> Probe:  # fmt: skip
    """Advance a probe by the cycle that ends a block with these means and spreads."""
    probe = dataclasses.replace(probe, measured=block(tip, spread), model=block(model, model_spread), **fields)
    pose = TipPose(seq=1, stamp_ns=0, position=tip, orientation=LEVEL)
    return advance_probe(use, probe, pose, np.array(model), watch, tendons, np.array(displacement))


def report(*tension: float, displacement: tuple[float, ...] = (0.0,) * 4) -> TendonState:
    return TendonState(seq=1, stamp_ns=0, tension=tension or (0.0,) * 4, displacement=displacement)
