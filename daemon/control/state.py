"""What the cycle knows: its setup, which never changes, and its state, which each cycle replaces."""

from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import lag_share
from tendond.daemon.control.commissioning.averages import RESTLESS, RestWatch
from tendond.daemon.control.commissioning.probe import Probe, ProbePlan, probe_limits
from tendond.daemon.control.commissioning.rests import RestFamily, configured_rests
from tendond.daemon.control.commissioning.tracking import JumpWatch, TrackingBounds, TrackingWatch
from tendond.daemon.control.gains import observer_gains
from tendond.daemon.control.selection import Choice, Plans
from tendond.daemon.control.sources import Sources
from tendond.daemon.control.thresholds import Thresholds
from tendond.model.estimation.observer import ObserverGains, ObserverState, start_observer
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.rod.tip import Tip
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.messages import Mode, TendonState, TipPose

Array = NDArray[np.float64]
T = TypeVar("T")


def changed(old: T, **changes: Any) -> T:
    """As `dataclasses.replace`, for dataclasses without initialiser of their own, in a tenth of its time.

    A cycle makes a dozen of these copies, of twenty fields each.
    """
    new = object.__new__(type(old))
    new.__dict__.update(old.__dict__)
    new.__dict__.update(changes)
    return new


def rod_from_section(section: RodSection, time_step: float) -> Rod:
    """The rod that a configuration describes.

    Args:
        section: [rod] or [simulator.rod].
        time_step: [s].
    """
    fields = section.model_dump(exclude={"space", "nodes", "alpha", "tendon_stiffness"})
    if section.tendon_stiffness is not None:
        fields["tendon_stiffness"] = section.tendon_stiffness
    return Rod(RodParameters(**fields), section.space, section.nodes, time_step, section.alpha)


@dataclass(frozen=True)
class CycleSetup:
    """What `cycle.step` is given beside state and inputs: the configuration, and what follows from it.

    Attributes:
        config: of the rig, with the robot's own rates where it names none.
        rod: the model.
        choice: law and reference that the configuration names.
        observer: its gains.
        lagging: part of a step that the actuators lack after a cycle [-].
        thresholds: of faults, in cycles.
        rests: that a right rig may have; none: they are not compared.
        probe: of the tendons, before the first pull; probe_limits: of the command meanwhile.
        plans: references that were planned beforehand.
        tracking: bounds of what is borne while it tracks.
    """

    config: RigConfig
    rod: Rod
    choice: Choice
    observer: ObserverGains
    lagging: float
    thresholds: Thresholds
    rests: RestFamily | None
    probe: ProbePlan
    probe_limits: LimitsSection
    tracking: TrackingBounds
    plans: Plans = field(default_factory=Plans)

    @staticmethod
    def from_config(config: RigConfig) -> "CycleSetup":
        """The setup of a configuration.

        Raises:
            LawError: an unknown law or parameter.
            ParameterError: a rod that cannot be.
            TargetError: a reference that the rod cannot reach.
            ConvergenceError: the rod has no equilibrium.
        """
        config = config.with_own_rates()
        rod = rod_from_section(config.rod, config.loop.period)
        section, period = config.observer, config.loop.period
        rests = configured_rests(config, rod.parameters)
        return CycleSetup(
            config=config,
            rod=rod,
            choice=Choice.from_config(config, rod),
            observer=observer_gains(config, rod.parameters),
            lagging=lag_share(section.lag, period),
            thresholds=Thresholds.from_config(config),
            rests=rests,
            probe=ProbePlan.from_config(config, rod.parameters, rests),
            probe_limits=probe_limits(config),
            tracking=TrackingBounds.from_config(config),
        )


@dataclass(frozen=True)
class Runs:
    """For how many cycles something has been wrong; the fault table's thresholds apply to these.

    What is judged by reports (rejected, teleports, equal_poses, mismatches, slack) counts the cycles from the first bad
    report to the newest one, the first for one: a slow camera is judged by the same time as a fast one.

    Attributes:
        disorder: cycles through which poses have come out of order, beside others that are used.
        objection: to the newest rejected pose.
        since_pose: cycles since a pose came, used or not.
    """

    rejected: int = 0
    teleports: int = 0
    missed_ticks: int = 0
    solver_failures: int = 0
    limited: int = 0
    equal_poses: int = 0
    occluded: int = 0
    mismatches: int = 0
    slack: int = 0
    odd_reports: int = 0
    objection: str = ""
    since_pose: int = 0
    disorder: int = 0
    since_disorder: int = 0


@dataclass(frozen=True)
class PoseAge:
    """Age of the newest pose by its stamp.

    Attributes:
        stamp_ns: of it. seconds: its age when it was used [s].
        least: difference of the two clocks at a pose that came at once [s].
        run: cycles for which poses have been too old.
    """

    stamp_ns: int = -1
    seconds: float = 0.0
    least: float = 1e18
    run: int = 0


YOUNG, STILL, UNWATCHED = PoseAge(), JumpWatch(), TrackingWatch()


@dataclass(frozen=True)
class CycleState:
    """State of the controller between two cycles.

    Attributes:
        tick: of the next cycle.
        mode, reason: see `Mode`; since: the tick at which the mode was entered.
        rod: of the model.
        tip: of that rod.
        observer: of the tip.
        choice: law and reference in use.
        pose: the newest one admitted; pose_age: cycles since it arrived.
        earlier: position of the pose before it [m], shape (3,); interval: cycles between the two.
        way: of the model's tip since the measured one last changed [m].
        tendon_state: the newest one; tendon_age: cycles since it arrived;
            tendon_interval: cycles between it and the one before.
        tension: that the actuators are estimated to apply [N]; commanded: told to them [N]; shapes (n,).
        wound: displacement that they are estimated to hold [m]; displacement: told to them [m]; shapes (n,).
        slip: of the reference along the straight rod [m], where that is not part of the target.
        lagging: the displacement is still on its way, held back by its rate.
        sources: who is listened to.
        runs: of bad cycles.
        rejected: inputs dropped since the start, by reason.
        rest: the tip while no tendon pulls.
        probe: that runs, or ran last; commissioned: one has passed, and nothing has changed since.
        age: of the pose. jump: of the measured tip. tracking: the tip against its reference.
        unreadable: which field of the first malformed message was wrong, and how; empty without one.
    """

    tick: int
    mode: Mode
    reason: str
    since: int
    rod: RodState
    tip: Tip
    observer: ObserverState
    choice: Choice
    pose: TipPose | None
    pose_age: int | None
    earlier: Array | None
    interval: int
    tendon_state: TendonState | None
    tension: Array
    commanded: Array
    wound: Array
    displacement: Array
    slip: float = 0.0
    way: float = 0.0
    tendon_age: int = 0
    tendon_interval: int = 1
    lagging: bool = False
    sources: Sources = field(default_factory=lambda: Sources({}, {}))
    runs: Runs = Runs()
    rejected: dict[str, int] = field(default_factory=dict)
    unreadable: str = ""
    rest: RestWatch = RESTLESS
    probe: Probe | None = None
    commissioned: bool = False
    age: PoseAge = YOUNG
    jump: JumpWatch = STILL
    tracking: TrackingWatch = UNWATCHED


def initial_state(setup: CycleSetup) -> CycleState:
    """Disarmed, slack, the model at rest under gravity.

    Raises:
        ConvergenceError: the model has no such rest.
    """
    n = setup.rod.parameters.tendon_count
    rod = setup.rod.solve_static(np.zeros(n))
    tip = setup.rod.tip(rod)
    return CycleState(
        tick=0,
        mode=Mode.STARTING,
        reason="starting",
        since=0,
        rod=rod,
        tip=tip,
        observer=start_observer(setup.observer, tip.position),
        choice=setup.choice,
        pose=None,
        pose_age=None,
        earlier=None,
        interval=1,
        tendon_state=None,
        tension=np.zeros(n),
        commanded=np.zeros(n),
        wound=np.zeros(n),
        displacement=np.zeros(n),
    )
