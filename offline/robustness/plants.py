"""The configuration of controller and plant at a point, and the timing of its run."""

import hashlib
import math

from tendond.offline.robustness.points import Point
from tendond.offline.robustness.unlike import unlike, with_elastic_tendons
from tendond.schemas.assumed_rig import SERVO_RATE
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.robot import RodSection

IDLE_CYCLES = 100
"""Disarmed cycles before arming, in which the observer estimates the load on the tip."""


TRACKING_CYCLES = 600
"""Cycles of tracking: the error that a mass on the tip leaves to the observer decays at one to three per second."""


IMPACT_CYCLES = 100
"""Cycles of a run after the beginning of an impact."""


SLACK = 0.002
"""Release of slack tendons where displacement drives [m]."""


def rig_of(base: RigConfig, point: Point, seed: int, model: RodSection | None = None) -> RigConfig:
    """Return the configuration of controller and plant of a point.

    Args:
        base: the controller's configuration; its [rod] is the plant's too, with the point's changes. Its own
            [simulator] is ignored.
        point: the point to run.
        seed: the run's seed; a point's noise depends on it and on the point.
        model: rod section that the controller uses instead of [rod].

    Raises:
        ConfigError: the point does not fit the configuration.
    """
    period, rod, limits = base.loop.period, base.rod, base.limits
    if point.drive == "displacement":
        rod = with_elastic_tendons(rod)
        rate = min(base.with_own_rates().limits.displacement_rate, SERVO_RATE)
        limits = limits.model_copy(update={"displacement_rate": rate, "slack": limits.slack or SLACK})
    configured_delay = point.delay_cycles + {"delay+1": 1, "delay-1": -1}.get(point.configured, 0)
    configured_lag = point.lag_factor + {"lag+0.1": 0.1, "lag-0.1": -0.1}.get(point.configured, 0.0)
    feedback = "direct" if point.feedback == "direct" else "observer"
    kind = "offset" if point.feedback == "offset" else "force"
    plant = unlike(rod, point.youngs_factor, point.bending_damping_factor, point.drag_factor)
    impacts = []
    if point.impact_n:
        force = [0.0, 0.0, 0.0]
        force["xyz".index(point.impact_direction[1])] = math.copysign(
            point.impact_n, float(point.impact_direction[0] + "1")
        )
        impacts.append({"time": impact_tick(base) * period, "duration": point.impact_ms / 1e3, "force": force})
    digest = hashlib.sha256(f"{seed}/{point.key}".encode()).digest()
    values = base.model_dump()
    values["rod"], values["limits"] = (model or rod).model_dump(), limits.model_dump()
    values["control"].update(law=point.law, feedback=feedback)
    values["observer"].update(kind=kind, delay=configured_delay * period, lag=time_constant(configured_lag, period))
    values["simulator"] = {
        "period": period,
        "rod": plant.model_dump(),
        "drive": point.drive,
        "weight": {"mass": point.load_g / 1e3},
        "impacts": impacts,
        "seed": int.from_bytes(digest[:4], "big"),
        "servo": {
            "lag": time_constant(point.lag_factor, period),
            "rate": limits.displacement_rate if point.drive == "displacement" else 0.0,
        },
        "mocap": {"latency": point.delay_cycles * period, "noise": point.noise_mm / 1e3},
    }
    values["vicon"] = values["servo"] = None
    return check_config(values, f"plant '{point}'").with_own_rates()


def time_constant(part: float, period: float) -> float:
    """Return the time constant [s] of a lag that lacks `part` of a step after `period` [s]."""
    return -period / math.log(part) if part > 1e-9 else 0.0


def impact_tick(config: RigConfig) -> int:
    """Return the cycle in which an impact begins, after `TRACKING_CYCLES` of tracking."""
    return IDLE_CYCLES + math.ceil(config.pretension.duration / config.loop.period - 1e-9) + TRACKING_CYCLES
