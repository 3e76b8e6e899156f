"""Setup of the cycle, which never changes: the configuration, and what follows from it."""

import math
from dataclasses import dataclass, field

from tendond.daemon.control.actuation import lag_factor_of
from tendond.daemon.control.commissioning.probe_plan import ProbePlan, probe_limits
from tendond.daemon.control.commissioning.rest_grid import configured_rests
from tendond.daemon.control.commissioning.rests import RestFamily
from tendond.daemon.control.commissioning.tracking import TrackingBounds
from tendond.daemon.control.estimation.estimator import configured_estimator
from tendond.daemon.control.gains import observer_gains
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.safety.barrier import Barrier
from tendond.daemon.control.safety.configured import configured_barrier
from tendond.daemon.control.selection import PlanCache, Selection
from tendond.daemon.control.sensors import Sensor, configured_sensors
from tendond.daemon.control.servos import configured_servo
from tendond.daemon.control.tasks.horizon import HorizonSpace
from tendond.daemon.control.thresholds import Thresholds
from tendond.daemon.control.tuning.keys import TunableKey, tunable_keys
from tendond.model.estimation.kalman.estimator import Estimator
from tendond.model.estimation.observer_gains import ObserverGains
from tendond.model.estimation.residual import Residual, residual_of
from tendond.model.rods.interface import ModelRod
from tendond.model.rods.selection import model_rod
from tendond.model.tendons.servo import ServoDynamics
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.rig import RigConfig

SLACK = 1e-3
"""Tension below which a lagging tendon that is commanded slack counts as slack, on the paper's robot [N], on others in
proportion to EI/(L r): it bends the rod by T r L/EI = 7e-5 rad, and moves the tip by a sixth of a camera's noise."""


@dataclass(frozen=True)
class CycleSetup:
    """Constant input of `cycle.step`: the configuration, and what follows from it.

    Attributes:
        config: configuration of the rig, with the robot's own rates where it names none.
        rod: the model.
        selection: law and reference that the configuration names.
        observer: its gains, where they are fixed. estimator: what takes its place, if it is configured.
        lag_factor: fraction of a step remaining after one cycle of the actuators' first-order lag [-].
        servo: dynamics of the servos, where they have more than that lag.
        thresholds: thresholds of faults, in cycles.
        rests: all that a right rig may have; none: they are not compared.
        probe: plan of the probe before the first pull; probe_limits: limits of the command meanwhile.
        plans: references that were planned beforehand.
        tracking_bounds: limits of what is tolerated while tracking.
        residual: learned correction of the model's tip, if there is one.
        slack: tension below which a tendon that is commanded slack counts as slack [N].
        sensors: configured ones beside the pose, by name.
        tunable: keys that may change while the controller runs, by path.
        barrier: the safety filter; none where nothing is configured.
    """

    config: RigConfig
    rod: ModelRod
    selection: Selection
    observer: ObserverGains
    estimator: Estimator | None
    lag_factor: float
    servo: ServoDynamics | None
    thresholds: Thresholds
    rests: RestFamily | None
    probe: ProbePlan
    probe_limits: LimitsSection
    tracking_bounds: TrackingBounds
    residual: Residual | None
    slack: float
    sensors: dict[str, Sensor]
    tunable: dict[str, TunableKey]
    barrier: Barrier | None = None
    plans: PlanCache = field(default_factory=PlanCache)

    @staticmethod
    def from_config(config: RigConfig) -> "CycleSetup":
        """Make the setup of a configuration.

        Raises:
            LawError: an unknown law or parameter.
            ParameterError: a rod that cannot be.
            TargetError: a reference that the rod cannot reach.
            ConvergenceError: the rod has no equilibrium.
            SafetyError: the resting arm breaks a constraint.
        """
        config = with_its_rod(config.with_own_rates())
        rod = model_rod(config)
        section, period = config.observer, config.loop.period
        rests, scale = configured_rests(config, rod.parameters), rod.parameters.tension_scale
        return CycleSetup(
            config=config,
            rod=rod,
            selection=Selection.from_config(config, rod),
            observer=observer_gains(config, rod.parameters),
            estimator=configured_estimator(config, rod),
            lag_factor=lag_factor_of(section.lag, period),
            servo=configured_servo(config),
            thresholds=Thresholds.from_config(config),
            rests=rests,
            probe=ProbePlan.from_config(config, rod.parameters, rests),
            probe_limits=probe_limits(config),
            tracking_bounds=TrackingBounds.from_config(config),
            residual=None if section.residual is None else residual_of(section.residual),
            slack=SLACK * scale if math.isfinite(scale) else SLACK,
            sensors=configured_sensors(config),
            tunable=tunable_keys(config),
            barrier=configured_barrier(config, rod, lag_factor_of(section.lag, period)),
        )


def with_its_rod(config: RigConfig) -> RigConfig:
    """Return a configuration with the general rod as its model, where its law needs that and no other is asked for."""
    law = LAWS.get(config.control.law)
    if config.control.solver is not None or law is None or not isinstance(law.task_space, HorizonSpace):
        return config
    return config.model_copy(update={"control": config.control.model_copy(update={"solver": "general"})})
