"""Gains of the observer: those of the configuration, as far as the loop's margin admits them."""

from functools import lru_cache

from tendond.daemon.control.laws import select_law
from tendond.daemon.control.laws.registry import BUILT_IN
from tendond.model.estimation.margin import admitted_gains, default_tip_mass
from tendond.model.estimation.observer_gains import (
    INNOVATION_TIME,
    NOISE_FLOOR,
    NOISE_SHARE,
    ObserverGains,
    default_force_max,
)
from tendond.model.estimation.poles import FeedbackGains, LawRates
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.config.rig import RigConfig

MASS_PARTS = (1.0, 0.25, 0.0625)
"""Parts of the usual unknown mass that are tried."""


def observer_gains(config: RigConfig, rod: RodParameters, *laws: str) -> ObserverGains:
    """Gains of the observer for a configuration and its rod's parameters, and the laws of `law_rates`.

    Raises:
        LawError: no such law, or a wrong parameter.
    """
    section, period = config.observer, config.loop.period
    mass = unknown_tip_mass(config, rod, *laws)
    gains = _gains_with(config, rod, mass, *laws)
    delay = section.delay + section.command_delay  # the model is ahead of the plant by the latter
    return ObserverGains(
        kind=section.kind if config.control.feedback == "observer" else "offset",
        period=period,
        delay=delay,
        delay_max=delay + config.faults.pose_age if section.stamps else delay,
        integral=gains.integral,
        proportional=gains.proportional,
        derivative=gains.derivative,
        noise_floor=NOISE_FLOOR * rod.length,
        noise_share=NOISE_SHARE,
        innovation_time=INNOVATION_TIME,
        force_max=default_force_max(rod, mass) if section.force_max is None else section.force_max,
        offset_gain=section.offset_gain,
    )


def usual_tip_mass(config: RigConfig, rod: RodParameters) -> float:
    """Mass on the tip that a controller need not know [kg], whatever its gains admit."""
    given = config.observer.tip_mass_max
    return default_tip_mass(rod) if given is None else given


def unknown_tip_mass(config: RigConfig, rod: RodParameters, *laws: str) -> float:
    """Mass on the tip that the controller with fixed gains need not know [kg].

    By default it is the usual one, or the part of it with which the loop admits an integral gain: without one, the
    error of a model that is a little too stiff stays for ever.
    """
    mass = usual_tip_mass(config, rod)
    if config.observer.tip_mass_max is not None:
        return mass
    for part in MASS_PARTS:
        if _gains_with(config, rod, part * mass, *laws).integral > 0.0:
            return part * mass
    return mass


def mass_remark(config: RigConfig, rod: RodParameters) -> str:
    """Say that the arm is stable with less on its tip than others of its stiffness; empty where it is not so."""
    section = config.observer
    if section.tip_mass_max is not None or section.kind != "force" or config.control.feedback != "observer":
        return ""
    mass, whole = unknown_tip_mass(config, rod), usual_tip_mass(config, rod)
    if mass >= whole:
        if section.integral == 0.0 or observer_gains(config, rod).integral > 0.0:
            return ""
        return (
            "observer: this loop admits no integral gain with an unknown mass on the tip: an error of the model's "
            'stiffness stays; set observer.tip_mass_max to what may hang there, or observer.kind = "kalman"'
        )
    return (
        f"observer: the loop of this lightly damped arm is stable with up to {1e3 * mass:.2g} g on its tip that the "
        f"model does not know, not with the usual {1e3 * whole:.2g} g: configure a tool or marker body as rod.tip"
    )


def _gains_with(config: RigConfig, rod: RodParameters, mass: float, *laws: str) -> FeedbackGains:
    """Return the gains with which the loop is stable up to an unknown mass on the tip [kg]."""
    section = config.observer
    wanted = FeedbackGains(section.integral, section.proportional, section.derivative, INNOVATION_TIME, NOISE_SHARE)
    delay = section.delay + section.command_delay
    return _admitted(rod, config.loop.period, config.rod.alpha, wanted, law_rates(config, *laws), delay, mass)


def law_rates(config: RigConfig, *names: str) -> LawRates:
    """Return the largest rates at which the laws make the model's tip converge.

    These are the built-in laws, that of `control.law`, all with a table in `control.laws`, and those of `names`. A law
    that does not say its convergence is taken for no faster than the others.

    Raises:
        LawError: no such law, or a wrong parameter.
    """
    tables = config.control.laws
    rates = []
    for name in dict.fromkeys([*(law.name for law in BUILT_IN), config.control.law, *tables, *names]):
        law, parameters = select_law(name, tables)
        says = getattr(law, "convergence", None)  # a law of another package may be without
        if says is not None and (convergence := says(parameters)) is not None:
            rates.append(convergence)
    ahead = max((one.rate, one.smoothing) for one in rates if one.smoothing is not None)
    return LawRates(max(one.rate for one in rates if one.smoothing is None), *ahead)


def rate_objection(config: RigConfig, rod: RodParameters, name: str) -> str:
    """Say that the observer's gains have no margin with the law `name`; empty if they have.

    The poles of a law that is not among those of `law_rates` are computed once: while the controller warms up.
    """
    if law_rates(config, name) == law_rates(config):
        return ""
    if observer_gains(config, rod, name) == observer_gains(config, rod):
        return ""
    return (
        f"control.law: {name} is faster than the laws for which the observer's gains keep a margin: add "
        f"[control.laws.{name}] to the configuration, and restart the controller"
    )


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
