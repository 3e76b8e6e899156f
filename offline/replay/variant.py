"""Another law, another parameter: on the recorded inputs, or in the closed loop with the simulator. Both make a log."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.errors import DaemonError, UsageError
from tendond.model import ModelError
from tendond.offline.files import as_text
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import SAME_INPUTS, LogFile, load
from tendond.offline.logs.run import Run, open_run
from tendond.offline.replay.offline import OfflineRunLog, record_lockstep
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import CycleInputs, CycleRecord


@dataclass(frozen=True)
class Commanded:
    """Differences of two runs' commands over the cycles that both have, for each tendon by itself.

    Attributes:
        cycles: the number of cycles that both have.
        tension_rms, tension_max: [N]. displacement_rms, displacement_max: [m].
        modes: cycles in which the modes differ.
    """

    cycles: int
    tension_rms: float
    tension_max: float
    displacement_rms: float
    displacement_max: float
    modes: int


def same_inputs(path: Path, config: RigConfig, out: Path, changes: str) -> Commanded:
    """Run the cycle on a log's inputs with another configuration, from the start, into a new log.

    The measured tip is that of the recorded run: it does not follow the new commands. What comes out is what the
    controller would have said to these measurements, not where the arm would have gone.

    Raises:
        UsageError: the configuration cannot be used, or the log does not begin with the first cycle.
    """
    recorded = load(path)
    if recorded.records[0].tick != 0:
        raise LogError(
            f"{path}: begins with cycle {recorded.records[0].tick}: its start, which is needed here, is lost"
        )
    setup = _setup(config)
    state = initial_state(setup)
    start_ns, period_ns = first_time(open_run(path)), round(config.loop.period * 1e9)
    records = []
    notes = _notes(path, SAME_INPUTS, changes)
    with OfflineRunLog(out, setup, notes, recorded.calibration) as run_log:
        run_log.at = start_ns
        run_log.state(state)
        for old in recorded.records:
            if state.tick != old.tick:  # cycles were left out while the arm was idle: it stays as it is
                state = replace(state, tick=old.tick)
            state, _, record = step(setup, state, old.inputs)
            run_log.at = start_ns + old.tick * period_ns
            run_log.cycle(record, None, state.rod, None)
            run_log.state(state)
            records.append(record)
    run_log.check()
    return compare_commands(recorded.records, records)


def closed_loop(path: Path, config: RigConfig, out: Path, changes: str) -> Commanded:
    """Run reference, loads and seeds of a log again on the simulator with another configuration, into a new log.

    The operator's requests come when the plant has taken as many steps as it had in the recorded run.

    Raises:
        UsageError: the configuration cannot be used.
    """
    recorded = load(path)
    requests, cycles, lead = _script(recorded)
    notes = _notes(path, "closed loop", changes)
    records = record_lockstep(_setup(config), cycles, requests, out, notes, recorded.calibration)
    return compare_commands(recorded.records, records, lead)


def compare_commands(one: list[CycleRecord], other: list[CycleRecord], lead: int = 0) -> Commanded:
    """Compare the commands of two runs, cycle by cycle; `lead` is added to the ticks of the first."""
    before = {record.tick + lead: record for record in one}
    pairs = [(before[record.tick], record) for record in other if record.tick in before]
    tension = np.array([np.subtract(b.command.tension, a.command.tension) for a, b in pairs])
    displacement = np.array([np.subtract(b.command.displacement, a.command.displacement) for a, b in pairs])
    return Commanded(
        cycles=len(pairs),
        tension_rms=float(np.sqrt(np.mean(tension**2))),
        tension_max=float(np.abs(tension).max()),
        displacement_rms=float(np.sqrt(np.mean(displacement**2))),
        displacement_max=float(np.abs(displacement).max()),
        modes=sum(a.mode is not b.mode for a, b in pairs),
    )


def first_time(run: Run) -> int:
    """Log time of the first cycle [ns]."""
    return next(message.log_time for topic, message in run.messages(("cycle",)))


def _notes(path: Path, kind: str, changes: str) -> dict[str, str]:
    return {"replay": kind, "replay_of": as_text(path.name), "replay_changes": changes or "none"}


def _setup(config: RigConfig) -> CycleSetup:
    try:
        return CycleSetup.from_config(config)
    except (DaemonError, ModelError) as error:
        raise UsageError(str(error)) from error


def _script(log: LogFile) -> tuple[dict[int, CycleInputs], int, int]:
    """Requests by tick of a run in lockstep, its length, and by how many cycles the plant was ahead."""
    simulated = log.config.simulator.period / log.config.loop.period
    lead = 0
    requests: dict[int, CycleInputs] = {}
    for record in log.records:
        if record.inputs.tendon_state is not None and log.truth:  # a simulator numbers its steps
            lead = round(record.inputs.tendon_state.seq * simulated) - record.tick
        if record.inputs.request is not None:
            requests[max(0, record.tick + lead)] = record.inputs
    return requests, max(1, log.records[-1].tick + lead + 1), lead
