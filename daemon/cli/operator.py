"""`tendond arm`, `stop`, `reset`, `status`: an operator's requests."""

from pathlib import Path

from rich.console import Console
from rich.table import Table

from tendond.daemon.cli.common import load_config
from tendond.daemon.errors import DaemonError
from tendond.drivers.operator import request
from tendond.schemas.messages import ControlAction, Status


def operate(action: str, config_file: Path | None) -> None:
    """Put the request and print the answer.

    Raises:
        TendondError: no controller, or it refused.
    """
    reply = request(load_config(config_file), ControlAction(action))
    if not reply.done:
        raise DaemonError(reply.message)
    print(reply.message)


def show_status(config_file: Path | None, *, as_json: bool) -> None:
    """Print the status as a table, or as JSON.

    Raises:
        TendondError: no controller.
    """
    reply = request(load_config(config_file), ControlAction.STATUS)
    if reply.status is None:
        raise DaemonError(f"the controller gave no status: {reply.message}")
    if as_json:
        print(reply.status.model_dump_json(indent=2))
    else:
        Console().print(_table(reply.status))


def _table(status: Status) -> Table:
    table = Table(title=f"rig {status.rig}", show_header=False)
    rows = {
        "mode": f"{status.mode.value} ({status.reason})",
        "law": f"{status.law}, fed by {status.feedback}",
        "tip": "no pose yet" if status.tip is None else _millimetres(status.tip),
        "target": _millimetres(status.target),
        "tension": " ".join(f"{value:.2f}" for value in status.tension) + " N",
        "displacement": _millimetres(status.displacement),
        "cycles": f"{status.loop.cycles}, {status.loop.missed_ticks} deadlines missed",
        "cycle time": f"median {status.loop.cycle_ms_median:.2f} ms, p99 {status.loop.cycle_ms_p99:.2f} ms",
        "rejected": ", ".join(f"{count} {reason}" for reason, count in status.rejected.items()) or "nothing",
        "log": status.loop.log_error or f"{status.loop.log_dropped} entries dropped",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def _millimetres(values: tuple[float, ...]) -> str:
    return " ".join(f"{value * 1e3:.1f}" for value in values) + " mm"
