"""The task of following poses with all tendons of a robot of sections, and what a law observes of it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.plan import first_mode
from tendond.daemon.control.pose.pose import Aim, Pose, turn
from tendond.daemon.control.pose.reference import PoseGoal, PoseReference
from tendond.daemon.control.pose.rests import PoseRest, PoseRests
from tendond.daemon.control.tasks.task import Decide, Ruling, Situation
from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rods.general import GeneralState
from tendond.model.rods.selection import model_rod
from tendond.model.strain.state import StrainState
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
        displacement_rate: of the tendons now [m/s], shape (n,).
        mobility: derivative of that after the coming step by the tensions [m/s/N], shape (n, n).
    """

    rest: PoseRest
    pose: Pose
    displacement_rate: Array
    mobility: Array


@dataclass(frozen=True)
class PoseObservation:
    """Inputs of a law that moves the tip's pose with all tendons.

    Attributes:
        pose: of the tip, as it is estimated.
        velocity: of the tip [m/s], shape (3,).
        goal: of the reference at the end of the step. now: of the reference now.
        led: pose to rest at, for the moving tip to be at the goal: see `led_pose`.
        counts: what of the pose is prescribed. radian: distance that counts as much as 1 rad [m].
        tension: now applied [N], shape (n,).
        tension_min, tension_max: bounds of every tension [N].
        period: of the cycle [s].
        still: the robot at rest under the present tensions; none where the model has no solution for it.
    """

    pose: Pose
    velocity: Array
    goal: PoseGoal
    now: PoseGoal
    led: Pose
    counts: Aim
    radian: float
    tension: Array
    tension_min: float
    tension_max: float
    period: float
    still: RestObservation | None


@dataclass(frozen=True)
class PoseTask:
    """Follow poses with all tendons.

    Attributes:
        reference: trajectory of poses.
        rests: equilibria of the model; with scratch memory of its own.
        period: period of the cycle [s].
        frequency: of the first mode [rad/s]. relaxation: twice its damping ratio over that [s].
    """

    reference: PoseReference
    rests: PoseRests
    period: float
    frequency: float
    relaxation: float

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""
        return np.full(len(self.rests.preferred), fraction * self.rests.tension_min)

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law."""
        decision = decide(self.observe(situation))
        return Ruling(decision, decision.tension)

    def observe(self, situation: Situation) -> PoseObservation:
        """Return the observation of a law of poses."""
        rests, elapsed = self.rests, situation.elapsed
        return PoseObservation(
            pose=Pose(situation.position, situation.tip.rotation),
            velocity=situation.velocity,
            goal=self.reference.pose(elapsed + self.period),
            now=self.reference.pose(elapsed),
            led=led_pose(self.reference, elapsed + self.period, self.frequency, self.relaxation),
            counts=self.reference.counts,
            radian=rests.radian,
            tension=situation.tension,
            tension_min=rests.tension_min,
            tension_max=rests.tension_max,
            period=self.period,
            still=self._still(situation),
        )

    def _still(self, situation: Situation) -> RestObservation | None:
        state, rests = situation.model, self.rests
        assert isinstance(state, GeneralState)
        force, acting, modes = situation.observer.tip_force, situation.acting, rests.rod.strain_rod.modes
        try:
            rest = rests.rest(acting, state, force)
            step = rests.linear.inputs(state.strain, rests.rod.loads(acting, force, state.body))
        except ConvergenceError:
            return None
        beside = situation.position - situation.tip.position
        moving = rests.linear.outputs(state.strain).displacement[:, :modes] @ mean_rate(state.strain)
        pose = Pose(rest.pose.position + beside, rest.pose.rotation)
        return RestObservation(rest, pose, moving, step.displacement / self.period)


def mean_rate(state: StrainState) -> Array:
    """Return the mean rate of the strains over the last step [1/s], shape (n,).

    That at its end alternates: no scheme that conserves energy damps modes which are faster than the step.
    """
    return state.rate if state.earlier is None else 0.5 * (state.rate + state.earlier[0])


def led_pose(reference: PoseReference, time: float, frequency: float, relaxation: float) -> Pose:
    """Return the pose at which the robot has to rest for its tip to be on the reference in motion.

    The first mode follows its rest y by y = q + relaxation q' + q''/frequency^2, q the tip: what is added is the
    static bend by inertia and damping. Higher modes are left out.

    Args:
        reference: trajectory. time: since tracking began [s].
        frequency: of the first mode [rad/s]. relaxation: twice its damping ratio over that [s].
    """
    goal, step = reference.pose(time), LEAD_PART / frequency
    after = turn(goal.pose, reference.pose(time + step).pose, "pose")
    before = turn(goal.pose, reference.pose(max(time - step, 0.0)).pose, "pose")
    turned = (after + before) / (step * frequency) ** 2 + relaxation * (after - before) / (2.0 * step)
    moved = goal.acceleration / frequency**2 + relaxation * goal.velocity
    rotation = np.asarray(Rotation.from_rotvec(turned).as_matrix()) @ goal.pose.rotation
    return Pose(goal.pose.position + moved, rotation)


def pose_task(config: RigConfig, reference: PoseReference) -> PoseTask:
    """Make the task, with a rod of its own.

    Raises:
        ParameterError: the rod is the shooting rod, or the bounds of the tensions leave no room.
    """
    tension_min, tension_max = config.pretension.tension_min, config.limits.tension_max
    if not 0.0 <= tension_min < tension_max:
        raise ParameterError(f"tension_min = {tension_min} N must lie in [0, {tension_max}), below tension_max")
    rests = PoseRests(model_rod(config), tension_min, tension_max, config.reference.posture)
    rod = rests.rod.parameters
    relaxation = rod.bending_damping[0] / rod.bending_stiffness
    return PoseTask(reference, rests, config.loop.period, first_mode(rod), relaxation)
