"""`tendond run`: the controller."""

import os
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

from tendond.bus.systemd import Supervisor
from tendond.cli.common import chosen_config, log_folder, say, stop_on_signals
from tendond.daemon.control.safety.configured import target_remark
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.errors import DaemonError, LawError, SafetyError
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.recording.storage.retention import retention
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.lockstep import Lockstep
from tendond.daemon.runtime.loop import Loop
from tendond.daemon.runtime.pacing import Clock, Pacer
from tendond.daemon.runtime.phase import PhaseLock
from tendond.daemon.runtime.planner import Planner
from tendond.daemon.runtime.realtime import be_prompt, become_punctual
from tendond.drivers.dynamixel.calibration import load_calibration
from tendond.model import ModelError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.progress import working
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.rig import ConfigError, RigConfig


def run_controller(
    config_file: Path | None,
    profile: str | None,
    log_file: Path | None,
    *,
    lockstep: bool,
    cycles: int | None,
    arm_at: int | None,
    notes: dict[str, str] | None = None,
) -> None:
    """Run until a signal comes, or for a number of cycles; see `tendond run --help`.

    Raises:
        TendondError: the configuration cannot be used, or the endpoint is taken.
    """
    config, source = chosen_config(config_file, profile)
    announce_compilation(say)
    kept = None
    if log_file is None:
        log_file = log_folder() / f"{config.rig.name}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap"
        kept = retention(config.log, log_file.parent, config.rig.name, service="LOGS_DIRECTORY" in os.environ)
    try:
        with working(f"setting up rig '{config.rig.name}'"):
            setup = CycleSetup.from_config(config)
    except (LawError, ModelError, SafetyError) as error:
        raise _refusal(source, error) from error
    calibration = _calibration(config, Path() if config_file is None else config_file.parent)
    written = RunLog(log_file, config, setup.rod, calibration=calibration, notes=notes, retention=kept)
    # The planner is forked, so it comes before there is a thread.
    with closing(Planner(setup)) as planner, Hub(config) as hub, written as run_log:
        supervisor = Supervisor()
        loop = Loop(setup, hub, run_log, arm_at, supervisor, planner, say)
        try:
            with working("running the first cycles, which count for nothing"):
                state = loop.warm()
        except ModelError as error:
            raise _refusal(source, error) from error
        hub.claim()
        stopped = stop_on_signals()  # until here a signal just ends the process: nothing has been commanded
        if lockstep:
            be_prompt()
            pacer: Pacer = Lockstep(hub, config.loop.period, stopped)
        else:
            period, speculate = config.loop.period, loop.speculate if config.loop.speculate else None
            phase = PhaseLock(period) if config.loop.phase_lock else None
            pacer = Clock(hub, period, speculate, run_log.rest_from, phase)
        if not lockstep and (missing := become_punctual(config.loop)):
            say(f"without real-time guarantees: {'; '.join(missing)}")
        for note in setup.selection.reference.notes:
            say(note)
        if remark := target_remark(setup.barrier, setup.selection.reference.target):
            say(remark)
        ready = f"rig '{config.rig.name}' on {config.bus.endpoint}: ready, disarmed; log {log_file}"
        say(ready)
        supervisor.ready(ready)
        loop.run(state, pacer, stopped, cycles)
    if run_log.error:
        raise DaemonError(f"stopped; the log is incomplete: {run_log.summary}; free or repair the disk")
    say(f"stopped; {run_log.summary}")


def _calibration(config: RigConfig, folder: Path) -> Calibration | None:
    """Load the calibration, for the log: the controller commands metres, which the servo driver turns into angles.

    Raises:
        CalibrationError: it is for another rig or other servos, unfinished or damaged.
    """
    if config.servo is None:
        return None
    path = folder / config.servo.calibration
    if not path.exists():
        say(f"the log will have no calibration: there is no {path}")
        return None
    return load_calibration(path, config.rig.name, config.servo.servo_ids(len(config.rod.tendon_positions)))


def _refusal(source: str, error: Exception) -> ConfigError:
    """Turn the error into one of the configuration that names its file."""
    return ConfigError("\n".join(f"{source}: {line}" for line in str(error).splitlines()))
