"""Dry run of a plan in lockstep with the simulator: to check that it is safe, and for logs whose truth is known."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.identification.excitation.plan import IdentificationPlan, PlanError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.simulator import Weight
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs

QUEUE = 10_000_000
"""Entries that may be queued for the disk: there is no real time here, and no entry may be lost."""

EPOCH_NS = 1_000_000_000


@dataclass(frozen=True)
class DryRun:
    """Result of a dry run.

    Attributes:
        tension: maximum command [N]. displacement: maximum command [m].
        speed: maximum speed of the tip [m/s].
        limited: fraction of the armed cycles with the command at a limit.
        tip: the plant's tip in each cycle [m], shape (cycles, 3).
    """

    tension: float
    displacement: float
    speed: float
    limited: float
    tip: NDArray[np.float64]


def dry_run(
    config: RigConfig, plan: IdentificationPlan, log: Path | None = None, notes: dict[str, str] | None = None
) -> DryRun:
    """Carry out a plan on the simulator of a configuration.

    Args:
        config: configuration of controller and simulator.
        plan: the plan.
        log: log to write, a new file; none: no log.
        notes: additional metadata of the log.

    Raises:
        PlanError: a request was refused, or the plan ended in a fault.
        RecorderError: the log cannot be written.
    """
    period = config.loop.period
    requests = {
        round(request.time / period): CycleInputs(request=request.action, reference=request.reference)
        for request in plan.requests
    }
    setup = CycleSetup.from_config(config)
    newest: list[CycleState] = []
    commands, tips, speeds, limited, armed = [], [], [], 0, 0
    at = [EPOCH_NS]
    run_log = None if log is None else RunLog(
        log, config, setup.rod, now=lambda: at[0], notes=notes, queue=QUEUE
    )  # fmt: skip
    if run_log is not None:
        run_log.__enter__()
    try:
        for watched in watched_loop(config, round(plan.duration / period), requests, see_state=newest.append):
            record = watched.record
            if run_log is not None:
                if len(newest) == 2:
                    run_log.state(newest[0])
                at[0] = EPOCH_NS + round(record.tick * period * 1e9)
                run_log.cycle(record, None, newest[-1].rod, watched.truth)
                run_log.state(newest[-1])
            newest[:] = newest[-1:]
            if record.mode is Mode.FAULT:
                raise PlanError(f"the plan ends in a fault at {record.time:.2f} s: {record.reason}")
            if record.inputs.request is not None and not record.accepted:
                raise PlanError(f"the plan's request at {record.time:.2f} s is refused: {record.reply}")
            commands.append((*record.command.tension, *record.command.displacement))
            tips.append(watched.truth.position)
            speeds.append(float(np.linalg.norm(watched.truth.velocity)))
            armed += record.command.armed
            limited += bool(record.limited)
    finally:
        if run_log is not None:
            run_log.__exit__()
    if run_log is not None and (run_log.error or run_log.dropped):
        raise PlanError(f"the log is incomplete: {run_log.summary}")
    n = len(commands[0]) // 2
    peak = np.max(np.array(commands), axis=0)
    return DryRun(
        tension=float(peak[:n].max()),
        displacement=float(peak[n:].max()),
        speed=max(speeds),
        limited=limited / max(1, armed),
        tip=np.array(tips),
    )


def rig_of_model(config: RigConfig, weight: float = 0.0) -> RigConfig:
    """Return the configuration with the controller's own model as the simulated robot, for a dry run."""
    simulator = config.simulator.model_copy(
        update={
            "rod": config.rod,
            "period": config.loop.period,
            "impacts": (),
            "weight": Weight(mass=weight),
        }
    )
    return config.model_copy(update={"simulator": simulator, "servo": None, "vicon": None})
