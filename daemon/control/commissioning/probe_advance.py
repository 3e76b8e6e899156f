"""Advance of the probe by a cycle: from rest through the pull of each tendon to the release, or to a verdict.

`python -m tests.constants` has the outcome with half and twice of each constant (docs/reliability.md).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.averages import EMPTY, RestWatch
from tendond.daemon.control.commissioning.probe import Probe, vector
from tendond.daemon.control.commissioning.probe_plan import MORE, Phase, ProbePlan
from tendond.daemon.control.commissioning.rest_check import rest_objection
from tendond.daemon.control.commissioning.verdict import Motion, agrees, judge, only_gain
from tendond.schemas.base import Vector3
from tendond.schemas.messages import TendonState, TipPose

Array = NDArray[np.float64]

TOGETHER = 0.004
"""Largest distance of the resting model from the measured rest, of the rod's length: a fifth of the default motion of a
probe. Half and twice of it change the probe's duration by 0.3 s, no verdict (`python -m tests.constants TOGETHER`)."""

MOVED_AT_REST = 0.02
"""Largest motion of a resting tip while the tendons are released, other than towards the slack rod's rest, of the rod's
length: the default motion of a probe.
Half and twice of it make no difference (`python -m tests.constants MOVED_AT_REST`)."""

AT_REST = 0.002
"""Largest motion of the model's tip in a block at rest, of the rod's length: a tenth of the default motion of a probe.
Half and twice of it make no difference (`python -m tests.constants AT_REST`)."""

CLOSE = 0.85, 1.2
"""Gains that pass without a second look, within the default 0.62 to 1.5 that pass at all. With those, a wrong rig
is armed; with 0.92 to 1.1 a probe takes 1 s longer (`python -m tests.constants CLOSE`)."""

STEADY_BLOCKS = 4
"""Blocks in a row with the same mean, of a tip that has settled elsewhere than expected; a weight swings slower.
2 and 8 change the longest probe by 1 s, no verdict (`python -m tests.constants STEADY_BLOCKS`)."""

STEADY = 0.15
"""Largest motion of a settled tip in a block, of the expected motion. With half of it the probe takes half as long
again, with twice a seventh less; no verdict changes (`python -m tests.constants STEADY`)."""

REST_LOAD_PART = 0.6
"""Reported tension that shows that a release pulls a tendon instead, of the probe's largest tension. With 1.0
such a tendon pulls 22 % of `limits.tension_max`, where it may pull 20 %, with 0.3 15 % in place of 17 %
(`python -m tests.constants REST_LOAD_PART`)."""


def advance_probe(
    plan: ProbePlan,
    probe: Probe,
    pose: TipPose | None,
    model_tip: Array,
    watch: RestWatch,
    tendons: TendonState | None,
    displacement: Array,
) -> Probe:
    """Return the probe a cycle later; pure.

    Args:
        plan: plan of it. probe: its state.
        pose: new in this cycle, if there is one.
        model_tip: [m], shape (3,).
        watch: watch of the tip at rest.
        tendons: newest report, if there is one.
        displacement: commanded [m], shape (n,).
    """
    x, y, z = model_tip.tolist()
    model = probe.model.add((x, y, z), (1.0, 0.0, 0.0, 0.0))
    measured = probe.measured if pose is None else probe.measured.add(pose.position, pose.orientation)
    probe = replace(probe, since=probe.since + 1, model=model, measured=measured)
    if pose is not None and probe.phase is Phase.PULL and probe.since > plan.start + plan.ramp + plan.settling // 2:
        probe = replace(probe, late=probe.late.add(pose.position, pose.orientation))
    if probe.phase is Phase.RELEASE:
        return replace(probe, phase=Phase.DONE) if probe.since > plan.down else probe
    if stop := _objection(plan, probe, pose, tendons):
        found = _so_far(probe, model_tip, pose)
        return replace(
            probe, phase=Phase.DONE, motions=found, verdict=judge(found, plan.bounds, plan.arms, finished=False) or stop
        )
    if model.count < plan.block or measured.count < 2:
        return probe
    block = _Block.of(probe)
    probe = replace(probe, model=EMPTY, measured=EMPTY)
    if probe.phase is Phase.REST:
        return _rested(plan, probe, block, watch, tendons, displacement)
    return _pulled(plan, probe, block, tendons, displacement)


@dataclass(frozen=True)
class _Block:
    """Means [m] and spreads [m] of a block."""

    measured: Vector3
    model: Vector3
    spread: float
    model_spread: float

    @staticmethod
    def of(probe: Probe) -> "_Block":
        measured, model = probe.measured, probe.model
        return _Block(vector(measured.mean), vector(model.mean), measured.spread, model.spread)


def _rested(
    plan: ProbePlan, probe: Probe, block: _Block, watch: RestWatch, tendons: TendonState | None, displacement: Array
) -> Probe:
    """Go on after a block of the phase `rest`: to the first tendon, or wait, or give up."""
    still = watch.before is not None and not watch.moved(plan.length) and block.model_spread < AT_REST * plan.length
    apart = math.dist(probe.in_base(block.measured), block.model)
    still = still and (apart < TOGETHER * plan.length or probe.since >= plan.rest + plan.settling)
    if probe.since >= plan.rest and still and watch.best is not None:
        if plan.rests is not None and (objection := rest_objection(plan.rests, watch)):
            return replace(probe, phase=Phase.DONE, verdict=objection)
        return replace(
            probe,
            phase=Phase.PULL,
            since=0,
            base=vector(watch.best.mean),
            model_base=block.model,
            displacement=(tuple(displacement.tolist()), () if tendons is None else tendons.displacement),
        )
    if probe.since >= plan.rest + 2 * plan.settling:
        return replace(probe, phase=Phase.DONE, verdict="the arm does not come to rest: is it blown at, or touched?")
    return probe


def _pulled(plan: ProbePlan, probe: Probe, block: _Block, tendons: TendonState | None, displacement: Array) -> Probe:
    """Go on after a block of the phase `pull`: to the next tendon if the tip has moved as it should, or has settled."""
    assert probe.base is not None
    assert probe.model_base is not None
    base = probe.base
    if probe.since < plan.start + plan.ramp + plan.block:
        return probe
    expected = np.subtract(block.model, probe.model_base)
    allowed = STEADY * float(np.linalg.norm(expected)) + 0.1 * STEADY * plan.motion
    settled = block.spread < allowed
    stands = probe.last is not None and math.dist(block.measured, probe.last) < 0.3 * allowed
    probe = replace(probe, last=block.measured, steady=probe.steady + 1 if settled and stands else 0)
    motion = Motion(
        vector(np.subtract(block.measured, base)),
        vector(expected),
        *_followed(probe, tendons, displacement),
        probe.first,
    )
    fair = settled and agrees(motion, plan.bounds)
    if fair and probe.first is None and not CLOSE[0] <= motion.gain <= CLOSE[1]:
        if probe.steady >= STEADY_BLOCKS:
            return _second_look(plan, probe, motion)
        if probe.since < plan.start + plan.ramp + plan.settling:
            return probe
    if not fair:
        waited = probe.since >= plan.start + plan.ramp + plan.settling
        if not waited and probe.steady < STEADY_BLOCKS:
            return probe
        if waited and probe.late.count:  # whole periods of a tip that still swings, too coarse for a growth
            motion = replace(
                motion,
                measured=vector(probe.late.mean - np.array(base)),
                first=None,
            )
        if probe.first is None and only_gain(
            motion, plan.bounds
        ):  # what was slack, or taut, before is distinguished from a spool
            return _second_look(plan, probe, motion)
    level = 1.0 if probe.first is None else MORE
    probe = replace(probe, motions=(*probe.motions, motion), since=0, late=EMPTY, last=None, steady=0)
    probe = replace(probe, first=None, released=level)
    if probe.tendon + 1 < len(plan.tensions):
        return replace(probe, tendon=probe.tendon + 1)
    return replace(probe, phase=Phase.RELEASE, verdict=judge(probe.motions, plan.bounds, plan.arms))


def _second_look(plan: ProbePlan, probe: Probe, motion: Motion) -> Probe:
    """Pull the same tendon some more, to see by how much the motion grows."""
    first = (motion.measured, motion.expected)
    return replace(probe, first=first, since=plan.start, late=EMPTY, last=None, steady=0)


def _followed(probe: Probe, tendons: TendonState | None, displacement: Array) -> tuple[float, float | None]:
    """Commanded displacement of the tendon since the rest, and the reported one [m]; none where none is reported."""
    assert probe.displacement is not None
    commanded, reported = probe.displacement
    asked = float(displacement[probe.tendon]) - commanded[probe.tendon]
    if tendons is None or len(reported) != len(commanded) or len(tendons.displacement) != len(commanded):
        return asked, None
    return asked, tendons.displacement[probe.tendon] - reported[probe.tendon]


def _objection(plan: ProbePlan, probe: Probe, pose: TipPose | None, tendons: TendonState | None) -> str:
    """Return the reason that ends the probe at once; empty if none does."""
    if tendons is not None:
        load = max(tendons.tension)
        if load > (REST_LOAD_PART if probe.phase is Phase.REST else 1.0) * plan.load_max:
            index = tendons.tension.index(load)
            if probe.phase is Phase.REST:
                return f"tendon {index} reports {load:.1f} N while all are released: is it wound the wrong way round?"
            return (
                f"tendon {index} reports {load:.1f} N while tendon {probe.tendon} is pulled with "
                f"{plan.tensions[probe.tendon]:.1f} N: is the servo's calibration right?"
            )
    if pose is not None and probe.phase is Phase.REST and probe.start is not None:
        moved, rest = math.dist(pose.position, probe.start), plan.slack_rest
        # A tendon that still held the arm lets it go home; one that is wound the wrong way pulls it away.
        home = rest is not None and math.dist(pose.position, rest) < math.dist(probe.start, rest)
        if moved > MOVED_AT_REST * plan.length and not home:
            return (
                f"the tip moves {moved * 1e3:.0f} mm while all tendons are released: is one of them wound the wrong "
                "way round?"
            )
    if pose is not None and probe.base is not None:
        moved = math.dist(pose.position, probe.base)
        if moved > plan.stop_at * (1.0 if probe.first is None else MORE):
            return (
                f"tendon {probe.tendon} moves the tip {moved * 1e3:.0f} mm where {plan.motion * 1e3:.0f} mm are "
                "expected: is the spool's radius, or the rod's stiffness, right?"
            )
    return ""


def _so_far(probe: Probe, model_tip: Array, pose: TipPose | None) -> tuple[Motion, ...]:
    """Add the motion in progress to the others, where it can be distinguished from rest."""
    if pose is None or probe.base is None or probe.model_base is None:
        return probe.motions
    measured, expected = np.subtract(pose.position, probe.base), model_tip - np.array(probe.model_base)
    return (*probe.motions, Motion(vector(measured), vector(expected)))
