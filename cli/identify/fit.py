"""`tendond identify LOG...` and `tendond identify plan`."""

import math
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import cast, get_args

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from tendond.cli.common import load_config, say
from tendond.cli.extras import need
from tendond.daemon.errors import DaemonError, UsageError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.identification.excitation.dry_run import DryRun, dry_run, rig_of_model
from tendond.offline.identification.excitation.plan import IdentificationPlan, propose, proposed_weight
from tendond.offline.identification.fitting.candidate import Trial
from tendond.offline.identification.fitting.solve import LOSSES, Loss
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import DEFAULT, chosen
from tendond.offline.identification.priors import parse_priors
from tendond.offline.identification.recordings.checks import Finding
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.identification.recordings.recording import Drive
from tendond.offline.identification.recordings.weights import parse_weights
from tendond.offline.identification.results.report import (
    Written,
    change_of,
    fitted_to,
    remark,
    warnings,
    write_results,
)
from tendond.offline.identification.results.residual import learn, summary
from tendond.offline.identification.results.result import Identification
from tendond.offline.progress import bars, working

UNFINISHED = ".unfinished"
"""Folder of what an interrupted fit has computed."""


AUTO = "auto"
"""Instead of names of parameters: those that the logs support."""


def run_fit(
    logs: list[Path],
    parameters: str | None,
    weight: list[str],
    hold_out: list[Path],
    out: Path,
    drive: str,
    load: float | None,
    loss: str,
    jobs: int | None,
    statics: bool | None,
    prior: list[str],
    *,
    residual: bool = False,
) -> None:
    """Identify, and write the results to `out`; see `tendond identify fit --help`.

    Raises:
        TendondError: invalid logs or options, a fit without result, a folder that cannot be written.
    """
    if drive not in ("auto", *get_args(Drive)):
        raise UsageError(f"--drive {drive}: choose among auto, {', '.join(get_args(Drive))}")
    if loss not in LOSSES:
        raise UsageError(f"--loss {loss}: choose among {', '.join(LOSSES)}")
    names = None
    if parameters != AUTO:
        names = tuple(parameter.name for parameter in chosen((parameters or ",".join(DEFAULT)).split(",")))
    weights = parse_weights(weight)
    for name in weights:
        if name not in {text for path in (*logs, *hold_out) for text in (str(path), path.name)}:
            raise UsageError(f"--weight {name}: is not one of the logs")
    options = Options(
        names,
        None if drive == "auto" else cast(Drive, drive),
        cast(Loss, loss),
        load,
        jobs or len(os.sched_getaffinity(0)),
        statics,
        parse_priors(prior),
    )
    need("matplotlib")
    announce_compilation(say)
    console = Console()
    unfinished = out / UNFINISHED
    try:
        with working("reading the logs"):
            recordings = [load_recording(path, weights) for path in logs]
            others = [load_recording(path, weights) for path in hold_out]
        columns = (TextColumn("{task.description:<24}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with bars(*columns) as progress:
            task = progress.add_task("checking", total=None)
            rounds = [0]

            def show(what: str, done: int, total: int) -> None:
                rounds[0] += what == "derivatives" and done == 1
                progress.update(task, description=f"round {rounds[0]}: {what}", completed=done, total=total)

            result = identify(recordings, others, options, show, unfinished, _report_warning)
        learned = None
        if residual:
            with working("learning the correction"):
                learned = learn(result.simulations, result.others, result.fit.values)
        with working("drawing"):
            written = write_results(result, out, datetime.now(UTC), learned)
        print_results(result, written, console)
        if learned is not None:
            console.print(summary(learned), highlight=False, soft_wrap=True)
    except (SystemExit, KeyboardInterrupt):
        if unfinished.is_dir():
            say(f"interrupted: partial results are in {unfinished}; run the same command again to resume")
        raise
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error


def _report_warning(finding: Finding) -> None:
    """Print a warning; errors are printed when they end the command."""
    if finding.level == "warning":
        say(f"warning: {finding.text}")


def print_results(result: Identification, written: Written, console: Console) -> None:
    """Print parameters, ratios, warnings and the files."""
    if result.trials:
        console.print(_trials(result.trials))
    if result.parameters:
        console.print(_table(result))
    else:
        console.print("none of the parameters is supported by the logs: the configuration explains them as it is")
    for ratio in result.ratios:
        error = f"{ratio.error / ratio.value:.2%}" if ratio.value else f"{ratio.error:.2g}"
        console.print(f"{ratio.name} = {ratio.value:.5g}, error {error}", highlight=False)
    for line in (f"fitted to: {fitted_to(result)}", f"scale of force: {result.scale}", *warnings(result)):
        console.print(line, highlight=False, soft_wrap=True)
    for recorded in result.held_out:
        console.print(
            f"{recorded.name}{'' if recorded.used else ', held out'}: model to tip {recorded.nominal_rms * 1e3:.2f} mm "
            f"by the configuration, {recorded.fitted_rms * 1e3:.3f} mm as identified",
            highlight=False,
            soft_wrap=True,
        )
    figures = ", ".join(map(str, written.figures))
    files = f"file     {written.parameters}\nreport   {written.report}\nfigures  {figures}"
    console.print(files, soft_wrap=True, highlight=False)


def _table(result: Identification) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for name in ("parameter", "configuration", "found", "error", "unit", ""):
        table.add_column(name, justify="right" if name in ("configuration", "found", "error") else "left")
    for found in result.parameters:
        value = f"{found.value:.5g}" if found.found else "-"
        error = "-"
        if found.found and math.isfinite(found.error):
            error = f"{found.error / found.value:.2%}" if found.parameter.logarithmic else f"{found.error:.2g}"
        table.add_row(found.parameter.name, f"{found.nominal:.5g}", value, error, found.parameter.unit, remark(found))
    return table


def _trials(trials: Sequence[Trial]) -> Table:
    table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=False)
    for name in ("candidate", "change of BIC", "taken", ""):
        table.add_column(name, justify="right" if name == "change of BIC" else "left")
    for trial in trials:
        table.add_row(trial.name, change_of(trial), "yes" if trial.taken else "no", trial.why)
    return table


def show_plan(config_file: Path | None, parts: str, reach: float) -> None:
    """Print a plan, its simulated result, and the next steps.

    Raises:
        TendondError: the configuration is invalid, or its limits leave no range.
    """
    config = load_config(config_file)
    announce_compilation(say)
    with working("planning, and running the plan on the simulator"):
        plan = propose(config, kinds(parts), reach)
        dry = dry_run(rig_of_model(config), plan)
    for line in plan_lines(plan, dry):
        print(line)
    option = f" --config {config_file}" if config_file else ""
    weight = proposed_weight(config)
    print(
        f"next: tendond identify run{option} --log free.mcap\n"
        f"then fix a known weight to the tip, about {weight * 1e3:.0f} g, and once it is at rest:\n"
        f"      tendond identify run{option} --log weighted.mcap --parts steps --reach 0.6 --weight {weight:g}\n"
        "      tendond identify free.mcap weighted.mcap\n"
        "without a known weight only ratios are identifiable: rho/E, Bbt/E, C/E, tendon_stiffness/E, tip_mass/E"
    )


def plan_lines(plan: IdentificationPlan, dry: DryRun) -> list[str]:
    """Format a plan."""
    lines = [f"{time:6.1f} s  {words}" for time, words in plan.parts]
    lines.append(f"{plan.duration:6.1f} s  end")
    lines.append(
        f"on the simulator: tension up to {dry.tension:.1f} N, tendon {dry.displacement * 1e3:.1f} mm, "
        f"tip {dry.speed:.1f} m/s; at a limit in {dry.limited:.0%} of the cycles"
    )
    return lines


def kinds(parts: str) -> tuple[str, ...]:
    """Parse `--parts` into names."""
    return tuple(part.strip() for part in parts.split(",") if part.strip())
