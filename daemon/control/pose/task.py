"""The task of following poses with all tendons of a robot of sections, and what a law observes of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.goals import counts_of, goal_at
from tendond.daemon.control.pose.plan import first_mode
from tendond.daemon.control.pose.pose import Aim, Pose, turn
from tendond.daemon.control.pose.reference import PoseGoal, PoseReference
from tendond.daemon.control.pose.rests import PoseRest, PoseRests
from tendond.daemon.control.reference.planar import REACHED
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation
from tendond.daemon.errors import TargetError
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rods.general import GeneralState
from tendond.model.rods.selection import model_rod
from tendond.model.strain.state import StrainState
from tendond.model.tendons.allocation import surround
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

LEAD_PART = 0.2
"""Step of the differences of a reference's rotation, of the first mode's radian: far below its period. Chosen."""


@dataclass(frozen=True)
class RestObservation:
    """The robot at rest under the tensions that act on it now, and its tendons' motion until then.

    Attributes:
        rest: the equilibrium, with its derivatives by all tensions.
        pose: pose of the tip there, moved by what the measured tip is beside the model's.
        rate: of the tip's position [m/s] and rotation [rad/s] now, shape (6,).
        rate_jacobian: derivative of that after the coming step by the tensions, shape (6, n).
        displacement_rate: of the tendons now [m/s], shape (n,).
        mobility: derivative of that after the coming step by the tensions [m/s/N], shape (n, n).
    """

    rest: PoseRest
    pose: Pose
    rate: Array
    rate_jacobian: Array
    displacement_rate: Array
    mobility: Array


@dataclass(frozen=True)
class PoseObservation:
    """Inputs of a law that moves the tip's pose with all tendons.

    Attributes:
        pose: of the tip, as it is estimated.
        velocity: of the tip [m/s], shape (3,).
        goal: of the reference at the end of the step. now: of the reference now.
        preferred: tensions to which redundant tendons tend [N], shape (n,).
        led: pose to rest at, for the moving tip to be at the goal: see `led_pose`.
        jumps: the reference begins with a jump of its velocity: the robot does not follow its motion then.
        counts: what of the pose is prescribed. radian: distance that counts as much as 1 rad [m].
        tension: now applied [N], shape (n,).
        tension_min, tension_max: bounds of every tension [N].
        period: of the cycle [s]. frequency: of the robot's first mode [rad/s].
        still: the robot at rest under the present tensions; none where the model has no solution for it.
    """

    pose: Pose
    velocity: Array
    goal: PoseGoal
    now: PoseGoal
    preferred: Array
    led: Pose
    jumps: bool
    counts: Aim
    radian: float
    tension: Array
    tension_min: float
    tension_max: float
    period: float
    frequency: float
    still: RestObservation | None


@dataclass(frozen=True)
class PoseTask:
    """Follow poses with all tendons, or what a reference prescribes of them.

    Attributes:
        reference: trajectory. counts: what of a pose it prescribes.
        rests: equilibria of the model; with scratch memory of its own.
        period: period of the cycle [s].
        frequency: of the first mode [rad/s]. relaxation: twice its damping ratio over that [s].
        jumps: the reference begins with a jump of its velocity.
    """

    reference: Reference
    counts: Aim
    rests: PoseRests
    period: float
    frequency: float
    relaxation: float
    jumps: bool

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""
        return np.full(len(self.rests.preferred), fraction * self.rests.tension_min)

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law."""
        decision = decide(self.observe(situation))
        return Ruling(decision, decision.tension)

    def observe(self, situation: Situation) -> PoseObservation:
        """Return the observation of a law of poses."""
        rests, elapsed, offset = self.rests, situation.elapsed, situation.offset
        goal = goal_at(self.reference, elapsed + self.period, offset)
        return PoseObservation(
            pose=Pose(situation.position, situation.tip.rotation),
            velocity=situation.velocity,
            goal=goal,
            now=goal_at(self.reference, elapsed, offset),
            preferred=rests.preferred if goal.tension is None else goal.tension,
            led=goal.pose
            if self.jumps
            else led_pose(self.reference, elapsed + self.period, self.frequency, self.relaxation, offset),
            jumps=self.jumps,
            counts=self.counts,
            radian=rests.radian,
            tension=situation.tension,
            tension_min=rests.tension_min,
            tension_max=rests.tension_max,
            period=self.period,
            frequency=self.frequency,
            still=self._still(situation),
        )

    def _still(self, situation: Situation) -> RestObservation | None:
        state, rests = situation.model, self.rests
        assert isinstance(state, GeneralState)
        force, acting, modes = situation.observer.tip_force, situation.acting, rests.rod.strain_rod.modes
        try:
            rest = rests.rest(acting, state, force, state.body)
            step = rests.linear.inputs(state.strain, rests.rod.loads(acting, force, state.body))
        except ConvergenceError:
            return None
        beside = situation.position - situation.tip.position
        outputs, mean = rests.linear.outputs(state.strain), mean_rate(state.strain)
        rate = np.concatenate((outputs.position[:, :modes] @ mean, outputs.rotation[:, :modes] @ mean))
        return RestObservation(
            rest=rest,
            pose=Pose(rest.pose.position + beside, rest.pose.rotation),
            rate=rate,
            rate_jacobian=step.whole[:6, :-6] / self.period,
            displacement_rate=outputs.displacement[:, :modes] @ mean,
            mobility=step.displacement / self.period,
        )


def mean_rate(state: StrainState) -> Array:
    """Return the mean rate of the strains over the last step [1/s], shape (n,).

    That at its end alternates: no scheme that conserves energy damps modes which are faster than the step.
    """
    return state.rate if state.earlier is None else 0.5 * (state.rate + state.earlier[0])


def led_pose(reference: Reference, time: float, frequency: float, relaxation: float, offset: float = 0.0) -> Pose:
    """Return the pose at which the robot has to rest for its tip to be on the reference in motion.

    The first mode follows its rest y by y = q + relaxation q' + q''/frequency^2, q the tip: what is added is the
    static bend by inertia and damping. Higher modes are left out.

    Args:
        reference: trajectory. time: since tracking began [s].
        frequency: of the first mode [rad/s]. relaxation: twice its damping ratio over that [s].
    """
    goal, step = goal_at(reference, time, offset), LEAD_PART / frequency
    after = turn(goal.pose, goal_at(reference, time + step).pose, "pose")
    before = turn(goal.pose, goal_at(reference, max(time - step, 0.0)).pose, "pose")
    turned = (after + before) / (step * frequency) ** 2 + relaxation * (after - before) / (2.0 * step)
    moved = goal.acceleration / frequency**2 + relaxation * goal.velocity
    rotation = np.asarray(Rotation.from_rotvec(turned).as_matrix()) @ goal.pose.rotation
    return Pose(goal.pose.position + moved, rotation)


def _check_reach(config: RigConfig, reference: Reference, rests: PoseRests) -> None:
    """Refuse a target across that the arm does not reach with all tendons at their least tension.

    Raises:
        TargetError: it is further from there than `REACHED`; or no equilibrium leads there.
    """
    if isinstance(reference, PoseReference) or counts_of(reference) != "across":
        return
    length, wanted = rests.rod.robot.length, Pose(np.array(reference.target), np.eye(3))
    try:
        start = rests.rest(np.full(len(rests.preferred), rests.tension_min))
        rest, apart = rests.find(wanted, "across", start)
    except ConvergenceError as error:
        raise TargetError(f"reference.across: the rod cannot rest on the way there: {error}") from error
    if apart.distance > REACHED * length:
        (x, y, _), low, high = (1e3 * rest.pose.position).tolist(), rests.tension_min, rests.tension_max
        raise TargetError(
            f"reference.across is {1e3 * apart.distance:.1f} mm beyond where the tip can rest with every tendon "
            f"between {low:g} and {high:g} N, which is ({x:.1f}, {y:.1f}) mm: change the target, lower "
            "pretension.tension_min, or raise limits.tension_max"
        )


def least_tension(config: RigConfig) -> float:
    """Return the smallest tension of every tendon [N]: the pretension, where the tendons hold it against each other."""
    opposed = surround(np.array(config.rod.tendon_positions))
    return config.pretension.tension_min if opposed else config.limits.tension_min


def pose_task(config: RigConfig, reference: Reference) -> PoseTask:
    """Make the task, with a rod of its own.

    Raises:
        ParameterError: the rod is the shooting rod, or the bounds of the tensions leave no room.
        TargetError: a target across is beyond where the arm can rest within them.
    """
    tension_min, tension_max = least_tension(config), config.limits.tension_max
    if not 0.0 <= tension_min < tension_max:
        raise ParameterError(f"tension_min = {tension_min} N must lie in [0, {tension_max}), below tension_max")
    rests = PoseRests(model_rod(config), tension_min, tension_max, config.reference.posture)
    rod = rests.rod.parameters
    relaxation = rod.bending_damping[0] / rod.bending_stiffness
    if config.reference.unreachable == "refuse":
        _check_reach(config, reference, rests)
    jumps, counts = not np.allclose(reference.at(0.0).velocity, 0.0), counts_of(reference)
    return PoseTask(reference, counts, rests, config.loop.period, first_mode(rod), relaxation, jumps)
