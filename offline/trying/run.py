"""Run a trial: controller and simulator as processes, an operator, a report, and the outcome in a line."""

import os
from collections.abc import Sequence
from pathlib import Path

from tendond import TendondError
from tendond.daemon.control.selection import Selection
from tendond.daemon.errors import DaemonError
from tendond.model.rods.selection import model_rod
from tendond.offline.demo.operated import Operated
from tendond.offline.logs.container import LogError
from tendond.offline.processes import free_port
from tendond.offline.trying.outcome import outcome_of
from tendond.offline.trying.task import RIG
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import CONFIG_VARIABLE

SETTLING = 3.0
"""Time of tracking after the reference has arrived [s]. Chosen: the slowest preset swings out in 2 s under its law."""

LOG = "try.mcap"
"""Name of a trial's log."""

LONGEST = 60.0
"""Longest time of tracking that is not asked for [s]."""


def tracking_time(config: RigConfig) -> float:
    """Return the time until the reference has arrived and the tip has settled [s], no longer than `LONGEST`.

    Raises:
        TendondError: the law or the reference cannot be used.
    """
    config = config.with_own_rates()
    arrival = Selection.from_config(config, model_rod(config)).reference.arrival
    return min(arrival + SETTLING, LONGEST)


def run_trial(text: str, remarks: Sequence[str], hold: float, out: Path) -> bool:
    """Run controller and simulator, and write log and report; the outcome is the last line.

    Args:
        text: configuration, TOML, without [bus].
        remarks: on it, printed first.
        hold: time of tracking [s].
        out: folder for log, configuration and report.

    Returns:
        True if the tip rests at its target.

    Raises:
        DaemonError: the folder cannot be written.
    """
    os.environ.pop(CONFIG_VARIABLE, None)  # a file of the rig's own bus, which this is not
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config_file, log_file, report_file = out / "rig.toml", out / LOG, out / "report.html"
    try:
        out.mkdir(parents=True, exist_ok=True)
        for old in (log_file, report_file):
            old.unlink(missing_ok=True)
        config_file.write_text(f'{text}\n[bus]\nendpoint = "{endpoint}"\n', encoding="utf-8")
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
    commands = {
        "controller": ("run", "--config", str(config_file), "--log", str(log_file)),
        "simulator": ("simulate", "--config", str(config_file)),
    }
    operated, failure = Operated(endpoint, RIG, commands, hold, name="trial"), ""
    for remark in remarks:
        operated.say("trial", remark)
    try:
        operated.run()
    except TendondError as error:
        failure = str(error)
    written = [f"log {log_file}"] if log_file.exists() else []
    if written:
        operated.say("report", f"writing {report_file}")
        try:
            _report(log_file, report_file)
            written.append(f"report {report_file}")
        except (LogError, OSError) as error:
            failure = failure or f"no report: {error}"
    arrived = False
    if not failure:
        try:
            outcome = outcome_of(log_file)
            arrived, said = outcome.arrived, outcome.in_words()
        except TendondError as error:
            said = f"failed: {error}"
    else:
        said = f"failed: {failure}"
    operated.say("outcome", "; ".join([said, *written]))
    return arrived


def _report(log: Path, out: Path) -> None:
    from tendond.offline.plots.report import write_report  # matplotlib takes a second

    write_report(log, out)
