"""`tendond log smooth`."""

import json
from dataclasses import asdict, replace
from pathlib import Path

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError, UsageError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.progress import working
from tendond.offline.smoothing.summary import Summary, summarise

FORMATS = (".csv", ".parquet", ".npz")


def run_smooth(file: Path, out: Path | None, changes: list[str], *, as_json: bool) -> None:
    """Smooth a log, write table and figure, and print what was found.

    Raises:
        LogError: the log cannot be used. UsageError: the table's name has another ending, or a change is invalid.
        DaemonError: a file cannot be written.
    """
    from tendond.offline.logs.export import check_export
    from tendond.offline.logs.log import load
    from tendond.offline.replay.changes import with_changes
    from tendond.offline.smoothing.figure import draw
    from tendond.offline.smoothing.results import table, write_table
    from tendond.offline.smoothing.smooth import smooth_log

    out = out or file.with_name(f"{file.stem}-smoothed.csv")
    if out.suffix not in FORMATS:
        raise UsageError(f"{out}: the name of the file says how it is written: end it in {', '.join(FORMATS)}")
    if out.suffix == ".parquet":
        check_export(out)
    log = load(file)
    log = replace(log, config=with_changes(log.config, None, changes))
    announce_compilation(say)
    with working(f"smoothing {file.name}", quiet=as_json) as work:
        found = smooth_log(log, lambda n, count, what: work.update(f"stretch {n + 1} of {count}, {what}"))
        work.update("writing")
        run = table(log, found.stretches)
        width = write_table(run, out)
        try:
            figure = draw(run, out.with_suffix(".png"))
        except OSError as error:
            raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another path with --out") from error
    summaries = [summarise(one) for one in found.stretches]
    if as_json:
        stretches = [asdict(one) for one in summaries]
        print(
            json.dumps(
                {"table": str(out), "figure": str(figure), "stretches": stretches, "left_out": found.left_out}, indent=2
            )
        )
        return
    for one in summaries:
        _show(one)
    for line in found.left_out:
        print(f"left out    {line}")
    print(f"table       {out}: {len(run)} cycles, {width} columns\nfigure      {figure}")


def _show(one: Summary) -> None:
    """Print the numbers of a stretch."""
    force = ", ".join(
        f"{axis} {value:.3g} +- {spread:.2g}"
        for axis, value, spread in zip("xyz", one.force, one.deviation, strict=True)
    )
    print(f"stretch     cycles {one.first} to {one.last}, {one.poses} poses; {one.passes} smoothers, ", end="")
    print(f"the last changed {one.change:.2g} standard deviations at most")
    print(f"pose        RMS {one.innovation_mm:.3g} mm from the filter's, {one.residual_mm:.3g} mm from the smoothed")
    print(
        f"consistency {one.consistency:.3g} (mean square of the innovations against their expected spread; 1 is right)"
    )
    print(f"force       largest at {one.time:.2f} s: {force} N")
    if one.jumps:
        print(f"load        came, went or changed at {', '.join(f'{time:.2f}' for time in one.jumps)} s")
    print(f"stiffness   {1e2 * one.stiffness:+.2g} % +- {1e2 * one.stiffness_deviation:.2g} % of the model's")
    if one.tip_mass is not None and one.tip_mass_deviation is not None:
        mass, spread = 1e3 * one.tip_mass, 1e3 * one.tip_mass_deviation
        print(f"mass        {mass:+.2g} +- {spread:.2g} g on the tip beside the model's")
    if one.unmeasured:
        print(f"not seen    {', '.join(one.unmeasured)}: known no better than assumed")
    if one.alike:
        print(f"not apart   {', '.join(one.alike)}: only a combination is known")
