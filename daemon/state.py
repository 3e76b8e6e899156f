"""What the cycle knows: its setup, which never changes, and its state, which each cycle replaces."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.laws import Law, LawParameters, select_law
from tendond.model.observer import ObserverState, start_observer
from tendond.model.parameters import RodParameters
from tendond.model.rod import Rod
from tendond.model.rod_state import RodState
from tendond.schemas.config import RigConfig, RodSection
from tendond.schemas.messages import Mode, TendonState, TipPose

Array = NDArray[np.float64]


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
    """What `cycle.step` is given beside state and inputs: the configuration, and what follows from it."""

    config: RigConfig
    rod: Rod
    law: Law
    law_parameters: LawParameters

    @staticmethod
    def from_config(config: RigConfig) -> "CycleSetup":
        """Raises LawError for an unknown law or parameter, ParameterError for a rod that cannot be."""
        law, parameters = select_law(config.control.law, config.control.laws)
        return CycleSetup(config, rod_from_section(config.rod, config.loop.period), law, parameters)


@dataclass(frozen=True)
class Runs:
    """How many cycles in a row something has been wrong; the fault table's thresholds apply to these."""

    rejected: int = 0
    teleports: int = 0
    missed_ticks: int = 0
    solver_failures: int = 0
    limited: int = 0


@dataclass(frozen=True)
class CycleState:
    """State of the controller between two cycles.

    Attributes:
        tick: of the next cycle.
        mode, reason: see `Mode`; since: the tick at which the mode was entered.
        rod: of the model.
        observer: of the tip.
        pose: the newest one admitted; pose_age: cycles since it arrived.
        earlier: position of the pose before it [m], shape (3,); interval: cycles between the two.
        tendon_state: the newest one.
        tension: commanded [N], displacement: commanded [m], shapes (n,).
        lagging: the displacement is still on its way, held back by its rate.
        runs: of bad cycles.
        rejected: inputs dropped since the start, by reason.
    """

    tick: int
    mode: Mode
    reason: str
    since: int
    rod: RodState
    observer: ObserverState
    pose: TipPose | None
    pose_age: int | None
    earlier: Array | None
    interval: int
    tendon_state: TendonState | None
    tension: Array
    displacement: Array
    lagging: bool = False
    runs: Runs = Runs()
    rejected: dict[str, int] = field(default_factory=dict)


def initial_state(setup: CycleSetup) -> CycleState:
    """Disarmed, slack, the model at rest under gravity.

    Raises:
        ConvergenceError: the model has no such rest.
    """
    n = setup.rod.parameters.tendon_count
    rod = setup.rod.solve_static(np.zeros(n))
    return CycleState(
        tick=0,
        mode=Mode.STARTING,
        reason="starting",
        since=0,
        rod=rod,
        observer=start_observer(setup.rod.tip(rod).position, setup.config.observer.delay),
        pose=None,
        pose_age=None,
        earlier=None,
        interval=1,
        tendon_state=None,
        tension=np.zeros(n),
        displacement=np.zeros(n),
    )
