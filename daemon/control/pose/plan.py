"""Plan a trajectory of poses: where the robot can rest, from the pretension on, as fast as the limits allow."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.path import PosePath
from tendond.daemon.control.pose.pose import Aim, Miss, Pose
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.rests import RELAX, PoseRest, PoseRests
from tendond.daemon.control.pose.timing import PathLimits, time_optimal, within
from tendond.daemon.control.pose.wanted import wanted_poses
from tendond.daemon.control.reference.strain import strain_note
from tendond.daemon.control.reference.time_scaling import SLOWDOWN_MAX, minimum_jerk
from tendond.daemon.control.servos import configured_servo, pulling_rates
from tendond.daemon.errors import TargetError
from tendond.model.errors import ConvergenceError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.friction import without_friction
from tendond.model.rods.interface import ModelRod
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

APPROACH_POINTS = 17
"""Equilibria from the pretension to the beginning of a trajectory."""

GOOD = 1e-4
"""Distance below which a pose counts as reached, of the backbone's length: no other start of the search is tried, and
it is not said that the trajectory was moved. A tenth of a camera's noise on an arm of 0.1 m. Chosen."""

SEED = 0.3
"""Tension of one tendon in another start of the search, of limits.tension_max. Chosen."""

SAG = 0.01
"""Bend of the arm by its own acceleration that the default of reference.acceleration_max allows, of its length."""


def follows_poses(config: RigConfig, section: ReferenceSection) -> bool:
    """Return whether a reference is one of poses: it says so, or the robot's tendons end at several places."""
    if not section.in_space or (section.aim == "direction" and not section.has_poses):
        return False
    if section.kind == "point" and section.position is None:
        return False
    length = config.rod.backbone_length
    ends = {round(length if one.end is None else one.end, 9) for one in config.rod.tendon}
    return section.has_poses or len(ends) > 1


def plan_poses(config: RigConfig, rod: ModelRod) -> PoseReference:
    """Plan the trajectory of poses that a configuration's [reference] asks for.

    Args:
        config: configuration of the rig.
        rod: the controller's model; its rests are taken without friction of the tendons.

    Raises:
        TargetError: it is further from where the tip can rest than `moved_max` and `turned_max`, or too fast.
        ParameterError: the rod is the shooting rod.
    """
    config = config.with_own_rates()
    section = config.reference
    rests = PoseRests(without_friction(rod), config.pretension.tension_min, config.limits.tension_max, section.posture)
    wanted = wanted_poses(section)
    try:
        start = rests.rest(np.full(len(rests.preferred), rests.tension_min))
        found, moved = _reached(section, rests, wanted.poses, wanted.counts, start)
        approach = [start]
        for part in np.linspace(0.0, 1.0, APPROACH_POINTS)[1:-1]:
            tension = start.tension + part * (found[0].tension - start.tension)
            approach.append(rests.rest(tension, approach[-1].state))
    except ConvergenceError as error:
        raise TargetError(f"reference.kind = '{section.kind}': the rod cannot rest where it leads: {error}") from error
    elastic, limits = config.rod.has_elastic_tendons, path_limits(config, rod.parameters)
    asked = [(PosePath(rests.rod, [*approach, found[0]], 1.0, elastic=elastic), minimum_jerk(1.0, section.duration))]
    if wanted.timing is not None:
        asked.append((PosePath(rests.rod, found, wanted.length, elastic=elastic), wanted.timing))
    notes = []
    if moved.distance > GOOD * rests.rod.robot.length or moved.angle > math.radians(0.1):
        notes.append(f"the trajectory was moved by up to {moved}, to where the tip can rest")
    notes += strain_note(config, rests.rod, [one.state for one in (*approach, *found)], "on the way")
    stretches = []
    for (path, given), name in zip(asked, ("the approach", "the trajectory"), strict=False):
        timing = time_optimal(path, limits) if section.timing == "optimal" else given
        timing, cause = within(timing, path, limits)
        if timing.slowed >= SLOWDOWN_MAX:
            raise TargetError(f"reference.kind = '{section.kind}': {cause} allows it at no speed")
        if section.timing == "optimal":
            notes.append(f"{name} takes {timing.end:.2f} s")
        elif cause:
            notes.append(f"{name} takes {timing.slowed:.2f} times as long as asked for, because of {cause}")
        stretches.append((path, timing))
    x, y, z = found[-1].pose.position.tolist()
    return PoseReference(wanted.counts, tuple(stretches), (x, y, z), moved, tuple(notes))


def path_limits(config: RigConfig, rod: RodParameters) -> PathLimits:
    """Return the limits along a path; [reference] has those of the tip, or with timing 'optimal' the robot itself."""
    section, servo = config.reference, configured_servo(config)
    omega = first_mode(rod)
    window, optimal = 2.0 * math.pi / omega, section.timing == "optimal"
    own = SAG * rod.length * omega**2 if optimal else math.inf
    acceleration = own if section.acceleration_max is None else section.acceleration_max
    jerk = math.inf if section.jerk_max is None else section.jerk_max
    return PathLimits(
        displacement_rate=config.limits.displacement_rate or math.inf,
        tension_rate=config.limits.tension_rate or math.inf,
        speed=math.inf if section.speed_max is None else section.speed_max,
        acceleration=acceleration,
        jerk=jerk,
        window=window,
        pulling=lambda tensions: pulling_rates(servo, tensions),
    )


def first_mode(rod: RodParameters) -> float:
    """Return the frequency of the first mode of a cantilever with a body on its tip [rad/s] (Timoshenko; Rayleigh)."""
    carried = rod.tip_mass + 3.0 / 3.516**2 * rod.mass_per_length * rod.length
    return math.sqrt(3.0 * rod.bending_stiffness / (carried * rod.length**3))


def _reached(
    section: ReferenceSection, rests: PoseRests, poses: list[Pose], counts: Aim, start: PoseRest
) -> tuple[list[PoseRest], Miss]:
    """Return the equilibria nearest to the poses, and the largest distance and angle.

    Raises:
        TargetError: one is too far; it names the nearest pose that can be reached.
    """
    found: list[PoseRest] = []
    distance, angle = 0.0, 0.0
    for pose in poses:
        rest, apart = rests.find(pose, counts, found[-1], RELAX) if found else _first(rests, pose, counts, start)
        if apart.distance > section.moved_max or apart.angle > section.turned_max:
            raise TargetError(
                f"reference.kind = '{section.kind}' leads to {described(pose, counts)}, {apart} from where the tip can "
                f"rest; the nearest reachable pose is {described(rest.pose, counts)}: change the target, or raise "
                f"reference.moved_max = {section.moved_max:g} m and turned_max = {section.turned_max:g} rad"
            )
        distance, angle = max(distance, apart.distance), max(angle, apart.angle)
        found.append(rest)
    return found, Miss(distance, angle)


def _first(rests: PoseRests, pose: Pose, counts: Aim, start: PoseRest) -> tuple[PoseRest, Miss]:
    """Return the equilibrium nearest to a pose, from several starts until one reaches it, and what is missing."""
    length, radian = rests.rod.robot.length, rests.radian
    best: tuple[PoseRest, Miss] | None = None
    for tension in _seeds(rests):
        try:
            begin = start if tension is None else rests.rest(tension, start.state)
            rest, apart = rests.find(pose, counts, begin)
        except ConvergenceError:
            continue
        size = math.hypot(apart.distance, radian * apart.angle)
        if best is None or size < math.hypot(best[1].distance, radian * best[1].angle):
            best = rest, apart
        if size < GOOD * length:
            break
    if best is None:
        raise ConvergenceError("statics: no search for the pose ends in an equilibrium", 0.0, 0.0, 0)
    return best


def _seeds(rests: PoseRests) -> list[Array | None]:
    """Return tensions from which a search begins: the pretension, then each tendon pulled."""
    seeds: list[Array | None] = [None]
    bend = rests.rod.parameters.bending_stiffness / rests.rod.robot.length
    for index, (x, y) in enumerate(rests.rod.parameters.tendon_positions):
        tension = np.full(len(rests.preferred), rests.tension_min)
        pull = min(SEED * rests.tension_max, 1.5 * bend / max(math.hypot(x, y), 1e-6))
        tension[index] = min(rests.tension_max, rests.tension_min + pull)
        seeds.append(tension)
    return seeds


def described(pose: Pose, counts: Aim) -> str:
    """Write a pose for people: millimetres, and the direction's angle to +z and azimuth in degrees."""
    x, y, z = (1e3 * pose.position).tolist()
    place = f"({x:.1f}, {y:.1f}) mm" if counts == "across" else f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
    if counts in ("position", "across"):
        return place
    a, b, c = pose.direction.tolist()
    tilt = math.degrees(math.atan2(math.hypot(a, b), c))
    return f"{place} with a tilt of {tilt:.1f} degrees towards {math.degrees(math.atan2(b, a)):.1f} degrees from +x"
