"""The estimator of a configuration, and what it is given in a cycle."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.daemon.control.estimation.moving_base import base_deviations
from tendond.daemon.control.estimation.spread import upper_half
from tendond.daemon.control.gains import law_rates, usual_tip_mass
from tendond.daemon.control.sensors import Reading as Admitted
from tendond.model.errors import ParameterError
from tendond.model.estimation.contact.state import Contact
from tendond.model.estimation.kalman import sensors
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.kalman.loop import admitted_noise
from tendond.model.estimation.kalman.memory import Reading
from tendond.model.estimation.kalman.noise import Noise, noise_of
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.observer import ObserverState
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.interface import ModelRod
from tendond.schemas.base import Quaternion
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.sensors.section import SensorSection
from tendond.schemas.record import ContactEstimate, FilterEstimate

Array = NDArray[np.float64]

MASS_SHARE = 0.2
"""Unknown mass with which the loop is to be stable, of that with fixed gains: a filter that takes a heavy tip for a
force that drifts would have to be as slow as those."""


def observer_kind(config: RigConfig) -> str:
    """Return the kind of observer: the configured one; with direct feedback there is only an offset."""
    if config.control.feedback == "direct":
        return "offset"
    return config.observer.kind


def configured_estimator(config: RigConfig, rod: ModelRod) -> Estimator | None:
    """Return the estimator of a configuration; none where its observer has fixed gains.

    Raises:
        ParameterError: the model is a rod without a filter.
    """
    if observer_kind(config) != "kalman":
        return None
    if not isinstance(rod, GeneralRod):
        raise ParameterError(
            'observer.kind = "kalman" needs the general rod, and the model is the shooting rod: set control.solver = '
            '"general", or observer.kind = "force"'
        )
    noise = configured_noise(config, rod)
    if config.control.feedback == "observer":
        section = config.observer
        delay, mass = section.delay + section.command_delay, MASS_SHARE * usual_tip_mass(config, rod.parameters)
        arm = max(math.hypot(*place) for place in rod.parameters.tendon_positions)
        noise = admitted_noise(rod.parameters, config.loop.period, noise, law_rates(config), delay, mass, arm)
    return estimator_with(config, rod, noise, configured_noise(config, rod) if config.observer.contact else None)


def configured_noise(config: RigConfig, rod: GeneralRod) -> Noise:
    """Return what a configuration says of the uncertain; a moving base's errors add to those of the pose."""
    section, (shift, turn) = config.observer, base_deviations(config)
    return noise_of(
        rod.parameters,
        math.hypot(section.pose_noise, shift, turn * rod.parameters.length),
        math.hypot(section.orientation_noise, turn) if section.orientation_noise else 0.0,
        section.tension_error,
        section.tension_error_time,
        section.stiffness_error,
        section.tip_mass_error,
    )


def estimator_with(config: RigConfig, rod: GeneralRod, noise: Noise, contacts: Noise | None = None) -> Estimator:
    """Return the estimator of a configuration's poses and sensors, with this noise; `contacts`: that of the search."""
    section = config.observer
    ages = [section.delay + (config.faults.pose_age if section.stamps else 0.0)]
    ages += [one.delay + (config.faults.pose_age if section.stamps else 0.0) for one in config.sensors]
    found = [_sensor(one, *base_deviations(config)) for one in config.sensors if one.kind != "base"]
    return Estimator(rod, noise, found, max(ages) + section.command_delay, contacts)


def _sensor(section: SensorSection, shift: float, turn: float) -> sensors.Sensor:
    """Return a sensor; `shift`, `turn`: deviations of the base's measured position [m] and rotation [rad]."""
    deviations = np.tile(section.deviations, section.rows)
    if section.kind == "markers":
        levers = np.repeat(section.at, section.width)
        deviations = np.sqrt(deviations**2 + shift**2 + (turn * levers) ** 2)
        return sensors.Markers(section.at, section.offsets, deviations)
    if section.kind == "curvature":
        return sensors.Curvature(section.at, deviations)
    if section.kind == "tension":
        return sensors.Tension(section.tendons, deviations)
    return sensors.Imu(deviations)


def filter_estimate(estimator: Estimator | None, estimate: ObserverState | EstimatorState) -> FilterEstimate | None:
    """Return what the record of a cycle says of the estimator; none where there is none."""
    if estimator is None or not isinstance(estimate, EstimatorState):
        return None
    factors, errors = estimator.factors(estimate), estimator.errors
    driven = slice(errors.force.start, errors.size)
    covariance = factors.along(np.eye(errors.size)[driven])
    deviation = np.sqrt(np.diag(covariance)).tolist()
    tendons = len(estimate.tension_error)
    return FilterEstimate.trusted(
        tip_covariance=upper_half(estimator.tip_covariance(estimate, factors)),
        force_covariance=upper_half(covariance[:3, :3]),
        tension_error=tuple(estimate.tension_error.tolist()),
        tension_deviation=tuple(deviation[3 : 3 + tendons]),
        bend_error=tuple(estimate.bend_error.tolist()),
        stiffness=1.0 + estimate.stiffness_error,
        stiffness_deviation=deviation[errors.stiffness - errors.force.start],
        tip_mass=estimate.tip_mass if estimator.noise.tip_mass > 0.0 else None,
        tip_mass_deviation=deviation[-1] if estimator.noise.tip_mass > 0.0 else None,
        consistency=estimate.consistency,
        load_tick=estimate.jumped if estimate.jumped >= 0 else None,
        contact=_contact(estimate.contact),
    )


def _contact(found: Contact | None) -> ContactEstimate | None:
    if found is None:
        return None
    (x, y, z), (dx, dy, dz) = found.force.tolist(), found.deviation.tolist()
    return ContactEstimate.trusted(
        place=found.place,
        first_place=found.first,
        last_place=found.last,
        force=(x, y, z),
        force_deviation=(dx, dy, dz),
        statistic=found.statistic,
        onset=found.onset,
        settled=found.settled,
    )


def pose_reading(position: Array, orientation: Quaternion | None, age: float) -> Reading:
    """Return a pose as the estimator takes it; `age`: against the model [s]. Without orientation, its place alone."""
    if orientation is None:
        return Reading(0, age, position)
    w, x, y, z = orientation
    return Reading(0, age, position, Rotation.from_quat((x, y, z, w)).as_matrix())


def other_readings(config: RigConfig, admitted: tuple[Admitted, ...]) -> list[Reading]:
    """Return the readings of the other sensors as the estimator takes them."""
    names = [one.name for one in config.sensors if one.kind != "base"]
    widths = {one.name: one.width for one in config.sensors}
    return [
        Reading(
            1 + names.index(one.name),
            one.age + config.observer.command_delay,
            np.array([number for row in one.rows for number in (row or (np.nan,) * widths[one.name])]),
        )
        for one in admitted
        if one.name in names
    ]
