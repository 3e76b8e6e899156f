"""The controller's status, from state and record of a cycle."""

import time

import numpy as np

from tendond.daemon.control.estimation.spread import deviation_along, ellipsoid
from tendond.daemon.control.phases.admission import describe_refusals
from tendond.daemon.control.sensors import Sensor, SensorTrack
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.sources import Sources
from tendond.daemon.control.state import CycleState
from tendond.daemon.control.tuning.tuning import Tuning
from tendond.schemas.health import ContactHealth, FilterHealth, LoopHealth, SensorHealth
from tendond.schemas.messages import Status, TunedValue
from tendond.schemas.record import ContactEstimate, CycleRecord, Intervention, ModelState, ObserverEstimate


def status_of(setup: CycleSetup, state: CycleState, record: CycleRecord, seq: int, health: LoopHealth) -> Status:
    """Return the status after a cycle.

    Args:
        setup: setup of the cycle.
        state: state after the cycle.
        record: record of the cycle.
        seq: count of the status.
        health: health of the loop.
    """
    config, period = setup.config, setup.config.loop.period
    return Status(
        seq=seq,
        stamp_ns=time.monotonic_ns(),
        rig=config.rig.name,
        mode=record.mode,
        reason=record.reason,
        tick=record.tick,
        law=record.law,
        feedback=config.control.feedback,
        tip=record.measured,
        target=record.reference.target,
        tension=record.command.tension,
        tension_estimate=record.tension_estimate,
        tip_tension=record.tip_tension,
        displacement=record.command.displacement,
        rejected=state.rejected,
        sources=_names(state.sources),
        sensors={one: sensor_health(setup.sensors[one], track, period) for one, track in state.sensors.items()},
        filter=filter_health(record.observer, record.model),
        safety=intervention_in_words(record.safety),
        refused=describe_refusals(state),
        tuned=tuned_values(setup, state.tuning),
        loop=health,
    )


def tuned_values(setup: CycleSetup, tuning: Tuning) -> dict[str, TunedValue]:
    """Return the tuned keys with their values."""
    if not tuning:
        return {}
    return {
        name: TunedValue(value=value, wanted=tuning.wanted[name], configured=setup.tunable[name].configured)
        for name, value in tuning.present.items()
    }


def sensor_health(sensor: Sensor, track: SensorTrack, period: float) -> SensorHealth:
    """Return rate or silence of a sensor; `period` of the cycle [s]."""
    return SensorHealth(
        rate=1.0 / (track.interval * period) if track.interval > 0.0 else None,
        age=None if track.age is None else track.age * period,
        silent=track.is_silent(sensor.timeout),
        objection=track.objection,
    )


def filter_health(observer: ObserverEstimate, model: ModelState) -> FilterHealth | None:
    """Return what the filter knows, from the record of a cycle; none where the observer is another."""
    found, force = observer.filter, np.array(observer.force)
    if found is None:
        return None
    return FilterHealth(
        force=float(np.linalg.norm(force)),
        force_deviation=deviation_along(found.force_covariance, force),
        tip_bound=float(ellipsoid(found.tip_covariance)[0][-1]),
        stiffness=found.stiffness,
        stiffness_deviation=found.stiffness_deviation,
        consistency=found.consistency,
        contact=None if found.contact is None else contact_health(found.contact),
        force_vector=observer.force,
        tip_covariance=found.tip_covariance,
        force_covariance=found.force_covariance,
        tip=model.position,
        tip_orientation=model.orientation,
        tip_mass=found.tip_mass,
        tip_mass_deviation=found.tip_mass_deviation,
    )


def contact_health(found: ContactEstimate) -> ContactHealth:
    """Return what is known of a contact, for the status."""
    return ContactHealth(
        place=found.place,
        first_place=found.first_place,
        last_place=found.last_place,
        force=found.force,
        force_deviation=found.force_deviation,
    )


def intervention_in_words(found: Intervention | None) -> str:
    """Say what the safety filter does; empty where it does nothing."""
    if found is None:
        return ""
    kept = "" if found.kept else "; no command keeps all constraints"
    return f"filtered by {found.constraint}: altered by {found.altered:.2g} N{kept}"


def _names(sources: Sources) -> dict[str, tuple[str, ...]]:
    """Return identities by key: the followed publisher's first, then that of another one."""
    names: dict[str, tuple[str, ...]] = {topic: (one.name,) for topic, one in sources.followed.items()}
    for topic, other in sources.others.items():
        names[topic] = (*names.get(topic, ()), other.name)
    return names
