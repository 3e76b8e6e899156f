"""Seeded runs of the estimator, and of fixed-gain observers beside it, on a robot that differs from the model."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.spatial.transform import Rotation

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import Noise, noise_of
from tendond.model.estimation.kalman.sensors import Markers
from tendond.model.estimation.margin import default_tip_mass
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.robot import Body, Robot
from tendond.offline.estimator.fixed_gain import FixedGain

Array = NDArray[np.float64]

PERIOD = 0.01
"""Period of the cycle [s]."""

POSITION, ORIENTATION = 1e-4, 2e-3
"""Noise of a camera: of a position [m], and of an orientation from markers 5 cm apart [rad]."""

SHARE, SHARE_TIME = 0.07, 3.0
"""Error of a tension, of it, in the filter's noise, and the time over which it changes [s]: chosen, so that ellipsoids
of 95 % hold that of a load too. Smaller and slower ones place the tip better."""

MASS_ERROR = 1.0 / 3.0
"""Deviation of the mass on the tip in the filter's noise, of the usual one with which a loop is to be stable."""

REST = 1.0
"""Time at rest at the beginning [s]."""


@dataclass(frozen=True)
class Case:
    """A kind of run.

    Attributes:
        name: of it. duration: [s].
        pose: the tip's pose is measured. markers: arc lengths of markers, as parts of the length.
        load: largest force on the tip that comes at `load_time` [EI/L^2]; load_time: [s].
        gap: time without any measurement, once a second, from 2 s on [s].
        lost: part of the markers that are not seen, at random.
        swapped: two markers' labels are exchanged for 0.2 s, each second.
        mass: largest unknown mass on the tip, of the usual one with which a loop is to be stable [-].
        weighed: the filter has the mass on the tip among its parameters.
    """

    name: str
    duration: float = 6.0
    pose: bool = True
    markers: tuple[float, ...] = ()
    load: float = 0.0
    load_time: float = 3.0
    gap: float = 0.0
    lost: float = 0.0
    swapped: bool = False
    mass: float = 0.0
    weighed: bool = False


@dataclass(frozen=True)
class Unlike:
    """Differences between the robot and its model.

    Attributes:
        stiffness: largest relative difference of E. friction: range of the tendons' friction.
        known: friction of them in the model.
    """

    stiffness: float = 0.1
    friction: tuple[float, float] = (0.05, 0.3)
    known: float = 0.15

    @classmethod
    def like(cls) -> "Unlike":
        """None: the robot is the model, and what is left is noise and what the filter leaves open."""
        return cls(stiffness=0.0, friction=(cls.known, cls.known))


@dataclass(frozen=True)
class Run:
    """What one run showed, cycle by cycle; shapes (cycles, ...).

    Attributes:
        time: [s]. tip: error of the estimated tip [m]. shape: RMS error along the backbone [m].
        force: error of the estimated force on the tip [N]; load: true force [N], each (cycles, 3).
        tip_square, force_square: squares of the errors in units of their expected spread.
        consistency: of the innovations. stiffness: error of the estimated stiffness. mass: of the mass on the tip [kg].
        fixed: error of the tip by each fixed-gain observer [m], shape (cycles, observers).
    """

    time: Array
    tip: Array
    shape: Array
    force: Array
    load: Array
    tip_square: Array
    force_square: Array
    consistency: Array
    stiffness: Array
    mass: Array
    fixed: Array


def robot_like(robot: Robot, rng: np.random.Generator, unlike: Unlike, mass: float = 0.0) -> GeneralRod:
    """Return a robot that differs from the model: in stiffness, friction of its tendons, and a mass on its tip [kg]."""
    friction = float(rng.uniform(*unlike.friction))
    tendons = tuple(replace(one, friction=friction) for one in robot.tendons)
    stiffness = 1.0 + float(rng.uniform(-unlike.stiffness, unlike.stiffness))
    bodies = (*robot.bodies, Body(robot.length, mass)) if mass > 0.0 else robot.bodies
    return GeneralRod(replace(robot, tendons=tendons, bodies=bodies), PERIOD, 1.0 / stiffness)


def tensions_along(rng: np.random.Generator, case: Case, tendons: int, largest: float) -> Array:
    """Return smooth random tensions after a rest [N], shape (cycles, m)."""
    knots = int(case.duration) + 2
    at = np.linspace(REST, case.duration, knots)
    time = np.clip(np.arange(round(case.duration / PERIOD)) * PERIOD, REST, case.duration)
    pulls = [PchipInterpolator(at, np.r_[0.0, rng.uniform(0.0, largest, knots - 1)])(time) for _ in range(tendons)]
    return np.asarray(np.stack(pulls, axis=1))


def noise_for(robot: Robot, tension_error: float = SHARE, tension_error_time: float = SHARE_TIME) -> Noise:
    """Return the filter's noise for these runs; arguments as the keys of [observer]."""
    parameters = GeneralRod(robot, PERIOD).parameters
    mass = MASS_ERROR * default_tip_mass(parameters)
    return noise_of(parameters, POSITION, ORIENTATION, tension_error, tension_error_time, 0.1, mass)


def run_one(robot: Robot, case: Case, seed: int, unlike: Unlike = Unlike(), noise: Noise | None = None) -> Run:
    """Run the estimator once, from a seed."""
    rng = np.random.default_rng(seed)
    mass = case.mass * default_tip_mass(GeneralRod(robot, PERIOD).parameters)
    mass *= float(np.random.default_rng(seed).uniform(0.25, 1.0))  # the others' draws are those without it
    plant = robot_like(robot, rng, unlike, mass)
    robot = replace(robot, tendons=tuple(replace(one, friction=unlike.known) for one in robot.tendons))
    model = GeneralRod(robot, PERIOD)
    parameters = model.parameters
    unit = parameters.bending_stiffness / parameters.length**2
    arm = max(float(np.hypot(*place)) for place in parameters.tendon_positions)
    largest = 0.8 * parameters.bending_stiffness / (parameters.length * arm)
    pulls = tensions_along(rng, case, len(robot.tendons), largest)
    direction = rng.normal(size=3)
    load = case.load * unit * rng.uniform(0.3, 1.0) * direction / np.linalg.norm(direction)
    known = noise_for(robot) if noise is None else noise
    known = known if case.weighed else replace(known, tip_mass=0.0)
    places = np.array(case.markers) * parameters.length
    sensors = [Markers(places, np.zeros(3), np.full(3 * len(places), POSITION))] if case.markers else []
    estimator = Estimator(model, known, sensors)
    truth = plant.solve_static(np.zeros(len(robot.tendons)))
    state = model.solve_static(np.zeros(len(robot.tendons)))
    estimate = estimator.start(state)
    fixed = FixedGain.all_of(model, state) if case.pose else []
    rows: list[tuple[object, ...]] = []
    for i, pull in enumerate(pulls):
        time = (i + 1) * PERIOD
        force = load if time > case.load_time else np.zeros(3)
        truth = plant.step(truth, pull, tip_force=force)
        after = estimator.step(estimate, state, pull)
        estimate = estimator.advance(estimate, state, after)
        for one in fixed:
            one.advance(pull)
        readings = measured(rng, case, plant, truth, places, time)
        estimate, state = estimator.correct(estimate, after, readings)
        for one in fixed:
            one.correct(readings[0].value if readings else None)
        factors, errors = estimator.factors(estimate), estimator.errors
        rows.append(
            (
                time,
                truth.position - state.position,
                _apart(plant, truth, model, state),
                estimate.force - force,
                force,
                _square(truth.position - state.position, estimator.tip_covariance(estimate, factors)),
                _square(estimate.force - force, factors.along(np.eye(errors.size)[errors.force])),
                estimate.consistency,
                (1.0 + estimate.stiffness_error) * plant.compliance - 1.0,
                estimate.tip_mass - mass,
                [float(np.linalg.norm(truth.position - one.tip)) for one in fixed],
            )
        )
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    columns[1] = np.linalg.norm(columns[1], axis=1)
    columns[3] = np.linalg.norm(columns[3], axis=1)
    return Run(*columns)


def measured(
    rng: np.random.Generator, case: Case, plant: GeneralRod, truth: GeneralState, places: Array, time: float
) -> list[Reading]:
    """Return what is measured at one cycle."""
    pose = truth.position + rng.normal(0.0, POSITION, 3)
    turned = Rotation.from_rotvec(rng.normal(0.0, ORIENTATION, 3)).as_matrix() @ plant.strain_rod.tip(truth.strain)[1]
    readings = [Reading(0, 0.0, pose, turned)] if case.pose else []
    if len(places):
        points = plant.backbone.frames(truth.strain, places)[0] + rng.normal(0.0, POSITION, (len(places), 3))
        points[rng.uniform(size=len(places)) < case.lost] = np.nan
        if case.swapped and time % 1.0 < 0.2:
            points[[0, 1]] = points[[1, 0]]
        readings.append(Reading(1, 0.0, points.reshape(-1)))
    return [] if time > 2.0 and time % 1.0 < case.gap else readings


def _apart(plant: GeneralRod, truth: GeneralState, model: GeneralRod, state: GeneralState) -> float:
    """RMS distance of two backbones [m]."""
    apart = plant.strain_rod.backbone(truth.strain) - model.strain_rod.backbone(state.strain)
    return float(np.sqrt(np.mean(np.sum(apart**2, axis=1))))


def _square(error: Array, covariance: Array) -> float:
    """Square of an error in units of its expected spread."""
    return float(error @ np.linalg.solve(covariance, error))
