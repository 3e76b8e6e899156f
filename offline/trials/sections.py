"""Trials of robots of sections: poses and paths of poses, run in lockstep, measured in millimetres and degrees."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.pose.pose import Aim, Pose, miss, rotation_to
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.pose.rests import PoseRests
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.rods.selection import model_rod
from tendond.offline.trials.measure import IDLE_CYCLES
from tendond.offline.trials.paths import Trial, config_of
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

GOAL_MM, GOAL_DEGREES = 3.0, 2.0
"""Goals of the root mean squares where the plant is the model."""

REST_SECONDS = 1.0
"""Time after the end of the trajectory that counts too."""

TENSION_MAX = 20.0
"""limits.tension_max of the robots [N]."""

BACKBONE_POINTS = 80
"""Points of the plant's backbone, whose last ones give its direction: to 0.01 degrees of a bend of 2 rad."""


@dataclass(frozen=True)
class SectionTrial:
    """A trajectory of a robot of sections.

    Attributes:
        robot: preset. name: of the trajectory. reference: its [reference].
        counts: what of the pose is prescribed. unlike: the plant is unlike the model, see `paths.UNLIKE`.
    """

    robot: str
    name: str
    reference: dict[str, Any]
    counts: Aim
    unlike: bool


@dataclass(frozen=True)
class SectionOutcome:
    """Measures of a trial, from the trajectory's beginning to `REST_SECONDS` after its end.

    Attributes:
        rms_mm, worst_mm: root mean square and maximum of the tip's distance from the reference [mm].
        rms_degrees, worst_degrees: the same of the angle between their directions; zero where none is prescribed.
        end_mm, end_degrees: at the end. min_tension: smallest one commanded while tracking [N].
        mode, reason: at the end.
    """

    rms_mm: float
    worst_mm: float
    rms_degrees: float
    worst_degrees: float
    end_mm: float
    end_degrees: float
    min_tension: float
    mode: str
    reason: str

    def meets(self, trial: SectionTrial) -> bool:
        """Return whether it ends without a fault, and where the plant is the model, within the goals."""
        within = trial.unlike or (self.rms_mm <= GOAL_MM and self.rms_degrees <= GOAL_DEGREES)
        return within and self.mode == Mode.TRACKING.value


def base_of(robot: str) -> RigConfig:
    """Return the configuration of a preset."""
    return check_config({"rod": {"preset": robot}, "limits": {"tension_max": TENSION_MAX}}, robot)


def loop_of_poses(robot: str, bend: float, counts: Aim, points: int = 12) -> list[tuple[float, ...]]:
    """Return poses that the robot passes when the bend of each section goes round once, the sections a third apart.

    Args:
        robot: preset. bend: of each section, of that of its largest tension [-].
        counts: 'direction' or 'pose': with a direction, or with a quaternion w, x, y, z. points: their number.
    """
    config = base_of(robot)
    rests = PoseRests(model_rod(config), config.pretension.tension_min, TENSION_MAX, "least_tension")
    places = np.array(config.rod.tendon_positions)
    ends = np.array([config.rod.backbone_length if one.end is None else one.end for one in config.rod.tendon])
    azimuth = np.arctan2(places[:, 1], places[:, 0])
    lag = 2.0 * math.pi / 3.0 * np.searchsorted(np.unique(ends), ends)
    rows: list[tuple[float, ...]] = []
    rest = None
    for phase in np.linspace(0.0, 2.0 * math.pi, points + 1):
        pull = bend * (TENSION_MAX - rests.tension_min) * np.maximum(np.cos(phase + lag - azimuth), 0.0)
        rest = rests.rest(rests.tension_min + pull, None if rest is None else rest.state)
        pose = rest.pose
        x, y, z, w = Rotation.from_matrix(pose.rotation).as_quat().tolist()
        turned = pose.direction.tolist() if counts == "direction" else [w, x, y, z]
        rows.append((*pose.position.tolist(), *turned))
    return rows


def section_trials(duration: float, *, quick: bool = False) -> list[SectionTrial]:
    """List the trials; `duration` of a path [s]; `quick`: one of them, of two sections."""
    found = []
    for unlike in (False, True):
        loop = {"kind": "path", "duration": duration, "turned_max": 0.2}
        two, three = "rao-2021", "franka-tdcr-v4"
        path = {**loop, "waypoints": loop_of_poses(two, 0.12, "direction")}
        found.append(SectionTrial(two, "path of position and direction", path, "direction", unlike))
        if quick:
            return found
        circle = {"kind": "circle", "center": (0.0, 0.0, 0.36), "radius": 0.1, "period": duration, "laps": 1}
        found.append(SectionTrial(two, "circle of 100 mm, position", circle, "position", unlike))
        path = {**loop, "waypoints": loop_of_poses(three, 0.10, "direction")}
        found.append(SectionTrial(three, "path of position and direction", path, "direction", unlike))
        path = {**loop, "waypoints": loop_of_poses(three, 0.10, "pose")}
        found.append(SectionTrial(three, "path of position and orientation", path, "pose", unlike))
    return found


def run_section_trial(trial: SectionTrial, seed: int = 0) -> SectionOutcome:
    """Run a trial in lockstep; `seed` of the camera's noise.

    Raises:
        TendondError: the trajectory cannot be followed, or the plant has no solution.
    """
    config = config_of(base_of(trial.robot), Trial(trial.name, trial.reference, trial.unlike), seed)
    reference = CycleSetup.from_config(config).selection.reference
    assert isinstance(reference, PoseReference)
    period = config.loop.period
    cycles = IDLE_CYCLES + math.ceil((config.pretension.duration + reference.arrival + REST_SECONDS) / period)
    errors: list[tuple[float, float]] = []
    tensions, mode, reason = [math.inf], "", ""
    tracked = 0
    for watched in watched_loop(config, cycles, {IDLE_CYCLES: ControlAction.ARM}, points=BACKBONE_POINTS):
        mode, reason = watched.record.mode.value, watched.record.reason
        if watched.record.mode is not Mode.TRACKING:
            continue
        time = tracked * period
        tracked += 1
        tensions.append(min(watched.record.command.tension))
        if time < reference.approach_time:
            continue
        pose = Pose(np.array(watched.truth.position), rotation_to(end_direction(watched.shape)))
        apart = miss(pose, reference.pose(time).pose, "position" if trial.counts == "position" else "direction")
        errors.append((1e3 * apart.distance, math.degrees(apart.angle)))
    return _measured(errors, min(tensions), mode, reason)


def end_direction(points: Array) -> Array:
    """Return the direction at the end of a curve [-], shape (3,), from points in equal steps, shape (k, 3)."""
    last, before = points[-1] - points[-2], points[-2] - points[-3]
    direction = 1.5 * last - 0.5 * before
    return np.asarray(direction / np.linalg.norm(direction))


def _measured(errors: Sequence[tuple[float, float]], tension: float, mode: str, reason: str) -> SectionOutcome:
    table = np.array(errors) if errors else np.full((1, 2), np.inf)
    rms, worst = np.sqrt(np.mean(table**2, axis=0)), table.max(axis=0)
    return SectionOutcome(
        rms_mm=float(rms[0]), worst_mm=float(worst[0]), rms_degrees=float(rms[1]), worst_degrees=float(worst[1]),
        end_mm=float(table[-1, 0]), end_degrees=float(table[-1, 1]), min_tension=tension, mode=mode, reason=reason,
    )  # fmt: skip
