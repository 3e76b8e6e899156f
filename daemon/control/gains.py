"""Gains of the observer: those of the configuration, as far as the loop's margin admits them."""

from functools import lru_cache

from tendond.daemon.control.laws import backstepping, sensitivity, sliding_mode
from tendond.model.estimation.margin import admitted_gains, default_tip_mass
from tendond.model.estimation.observer import (
    INNOVATION_TIME,
    NOISE_FLOOR,
    NOISE_SHARE,
    ObserverGains,
    default_force_max,
)
from tendond.model.estimation.poles import FeedbackGains, LawRates
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.config.rig import RigConfig


def observer_gains(config: RigConfig, rod: RodParameters) -> ObserverGains:
    """Gains of the observer for a configuration and its rod's parameters."""
    section, period = config.observer, config.loop.period
    mass = unknown_tip_mass(config, rod)
    wanted = FeedbackGains(section.integral, section.proportional, section.derivative, INNOVATION_TIME, NOISE_SHARE)
    gains = _admitted(rod, period, config.rod.alpha, wanted, law_rates(config), section.delay, mass)
    return ObserverGains(
        kind=section.kind if config.control.feedback == "observer" else "offset",
        period=period,
        delay=section.delay,
        integral=gains.integral,
        proportional=gains.proportional,
        derivative=gains.derivative,
        noise_floor=NOISE_FLOOR * rod.length,
        noise_share=NOISE_SHARE,
        innovation_time=INNOVATION_TIME,
        force_max=default_force_max(rod, mass) if section.force_max is None else section.force_max,
        offset_gain=section.offset_gain,
    )


def unknown_tip_mass(config: RigConfig, rod: RodParameters) -> float:
    """Mass on the tip that the controller need not know [kg]."""
    given = config.observer.tip_mass_max
    return default_tip_mass(rod) if given is None else given


def law_rates(config: RigConfig) -> LawRates:
    """Return the rates at which the laws make the model's tip converge, by their parameters."""
    tables = config.control.laws
    step = backstepping.Parameters(**tables.get("backstepping", {}))
    slide = sliding_mode.Parameters(**tables.get("sliding_mode", {}))
    ahead = sensitivity.Parameters(**tables.get("sensitivity", {}))
    a1, a2 = step.alpha1, step.alpha2
    velocity = max((1.0 + a1 * a2) / (a1 + a2), slide.c * slide.k / (slide.c + slide.k))
    return LawRates(velocity, ahead.rate, ahead.smoothing)


def lowered(config: RigConfig, rod: RodParameters) -> str:
    """Describe the gains that are lower than the configuration asks for; empty where none is."""
    section, gains = config.observer, observer_gains(config, rod)
    if gains.kind != "force":
        return ""
    changes = [
        f"observer.{name} {getattr(section, name):g} -> {getattr(gains, name):.3g}"
        for name in ("integral", "proportional", "derivative")
        if name in section.model_fields_set and getattr(gains, name) < getattr(section, name)
    ]
    if not changes:
        return ""
    mass = unknown_tip_mass(config, rod)
    return (
        f"{', '.join(changes)}, to stay stable with 0 to {mass * 1e3:.0f} g on the tip that the model does "
        f"not know and poses {section.delay * 1e3:.0f} ms old; a smaller observer.tip_mass_max or delay admits more"
    )


_admitted = lru_cache(maxsize=256)(admitted_gains)
