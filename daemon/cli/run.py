"""`tendond run`: the controller."""

from datetime import UTC, datetime
from pathlib import Path

from tendond.daemon.bus import Hub
from tendond.daemon.cli.common import load_config, say, stop_on_signals
from tendond.daemon.errors import LawError
from tendond.daemon.journal import Journal
from tendond.daemon.loop import Loop
from tendond.daemon.pacing import Clock, Lockstep
from tendond.daemon.state import CycleSetup
from tendond.model.announce import announce_compilation
from tendond.schemas.config import ConfigError


def run_controller(
    config_file: Path | None, log_file: Path | None, *, lockstep: bool, cycles: int | None, arm_at: int | None
) -> None:
    """Run until a signal comes, or for so many cycles; see `tendond run --help`.

    Raises:
        TendondError: the configuration cannot be used, or the endpoint is taken.
    """
    config = load_config(config_file)
    stopped = stop_on_signals()
    announce_compilation(say)
    try:
        setup = CycleSetup.from_config(config)
    except LawError as error:
        raise ConfigError("\n".join(f"{config_file}: {line}" for line in str(error).splitlines())) from error
    if log_file is None:
        log_file = Path("log") / f"{config.rig.name}-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap"
    with Hub(config) as hub, Journal(log_file, config, setup.rod) as journal:
        loop = Loop(setup, hub, journal, stopped, arm_at)
        state = loop.warm()
        pacer = Lockstep(hub, stopped) if lockstep else Clock(hub, config.loop.period)
        say(f"rig '{config.rig.name}' on {config.bus.endpoint}: ready, disarmed; log {log_file}")
        loop.run(state, pacer, cycles)
    say(f"ended: {journal.summary}")
