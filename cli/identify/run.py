"""`tendond identify run`: plan, dry run and consent; then the recording."""

from datetime import UTC, datetime
from pathlib import Path

from tendond.cli.common import load_config, say
from tendond.cli.identify.fit import kinds, plan_lines
from tendond.daemon.errors import DaemonError, UsageError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.identification.excitation.dry_run import dry_run, rig_of_model
from tendond.offline.identification.excitation.operator import record_plan, refuse_another_controller
from tendond.offline.identification.excitation.plan import propose
from tendond.offline.progress import working


def run_plan(config_file: Path | None, log: Path | None, parts: str, reach: float, weight: float, *, yes: bool) -> None:
    """Dry-run a plan, ask, and carry it out; see `tendond identify run --help`.

    Raises:
        TendondError: a configuration whose limits leave no range, a plan that fails in the dry run, a controller
            that cannot be started, a fault while it runs.
    """
    config = load_config(config_file)
    if log is None:
        log = Path("log") / f"{config.rig.name}-identify-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap"
    if log.exists():
        raise UsageError(f"{log}: exists: a log is never overwritten; choose another --log")
    refuse_another_controller(config)
    announce_compilation(say)
    with working("planning, and running the plan on the simulator"):
        plan = propose(config, kinds(parts), reach)
        dry = dry_run(rig_of_model(config, weight), plan)
    for line in plan_lines(plan, dry):
        print(line, flush=True)
    if not yes and input(f"Weight on the tip: {weight:g} kg. Is the arm free to move? [y/N] ").strip() not in (
        "y",
        "Y",
    ):
        raise DaemonError("not started: not confirmed")
    record_plan(config, config_file, plan, log, weight, say)
    print(f"recorded: {log}\nnext:     tendond identify {log}")
