"""`tendond log info`, `recover`, `export`, `report`."""

import json
from pathlib import Path


def run_info(file: Path, *, as_json: bool) -> None:
    """Print contents and health.

    Raises:
        LogError: the log cannot be used.
    """
    from tendond.offline.logs.info import info
    from tendond.offline.progress import working

    with working(f"reading {file.name}", quiet=as_json):
        found = info(file)
    if as_json:
        print(json.dumps(found, indent=2))
        return
    meta = found["metadata"]
    print(f"{', '.join(found['files'])}: {found['bytes'] / 1e6:.2f} MB, {_health(found['complete'], found['damage'])}")
    print(f"rig      {meta.get('rig', 'not named')}, started {found['started']}, {found['duration_s']:.2f} s")
    if calibration := found["calibration"]:
        spools = ", ".join(f"servo {one['servo']} zero {one['zero']}" for one in calibration["tendons"])
        print(f"servos   calibrated {calibration['date']}: {spools}")
    print(
        f"cycles   {found['cycles']}, ticks {found['first_tick']} to {found['last_tick']}, "
        f"{found['left_out']} omitted while idle, {found['missing_ticks']} not in the log, "
        f"{found['missed_deadlines']} deadlines missed, "
        f"{found['snapshots']} states to replay from"
    )
    for change in found["modes"]:
        print(f"mode     {change['tick']:>8}  {change['mode']}: {change['reason']}")
    for fault in found["faults"]:
        print(f"fault    {fault['tick']:>8}  to clear it: {fault['to_clear']}")
    if readings := found["readings"]:
        print(f"sensors  {', '.join(f'{name} {count} readings' for name, count in readings.items())}")
    print(f"rejected {', '.join(f'{count} {reason}' for reason, count in found['rejected'].items()) or 'nothing'}")
    print(f"entries  {', '.join(f'{count} {topic}' for topic, count in found['messages'].items())}")
    print(f"versions {', '.join(f'{name} {value}' for name, value in meta.items() if name != 'rig')}")
    for line in found["damage"]:
        print(f"damage   {line}")


def _health(complete: bool, damage: list[str]) -> str:
    if complete and not damage:
        return "complete"
    return "finished, but damaged" if complete else "not finished (writer killed, or disk full)"


def run_recover(file: Path, out: Path | None) -> None:
    """Recover the intact part, and print what was lost.

    Raises:
        LogError: the log cannot be used. UsageError: the new file cannot be written.
    """
    from tendond.offline.logs.recover import recover
    from tendond.offline.logs.ticks import shown
    from tendond.offline.progress import working

    out = out or file.with_name(f"{file.stem}-recovered.mcap")
    with working(f"recovering {file.name}"):
        found = recover(file, out)
    kept = f"{found.messages} entries" + (
        f", {found.cycles} cycles, ticks {found.first} to {found.last}" if found.cycles else ""
    )
    print(f"{out}: {kept}")
    for damage in found.damage:
        print(f"lost: {damage}")
    for stretch in found.missing:
        print(f"missing: {shown(stretch)}")
    if not found.damage and not found.missing:
        print("lost: nothing" + ("" if found.complete else " but the end, which was never written"))


def run_export(file: Path, out: Path | None) -> None:
    """Export a table.

    Raises:
        LogError: the log cannot be used. UsageError: the table cannot be written.
    """
    from tendond.offline.logs.arrays import load
    from tendond.offline.logs.export import check_export, export
    from tendond.offline.progress import working

    out = out or file.with_suffix(".csv")
    check_export(out)
    with working(f"exporting {file.name}"):
        run = load(file)
        columns = export(run, out)
    print(f"{out}: {len(run)} cycles, {columns} columns")


def run_bag_export(file: Path, out: Path | None, distribution: str) -> None:
    """Export a rosbag2 folder.

    Raises:
        LogError: the log cannot be used. UsageError: the folder exists. DaemonError: it cannot be written.
    """
    from tendond.cli.extras import need
    from tendond.offline.progress import working

    need("rosbags")
    from tendond.offline.rosbag.export import check_bag, export_bag

    out = out or file.with_name(f"{file.stem}-rosbag2")
    check_bag(out)
    with working(f"exporting {file.name}"):
        counts = export_bag(file, out, distribution)
    print(f"{out}: {sum(counts.values())} messages on {len(counts)} topics; ros2 bag play {out}")


def run_report(file: Path, out: Path | None) -> None:
    """Write the report.

    Raises:
        LogError: the log cannot be used. DaemonError: the page cannot be written.
    """
    from tendond.cli.log.figures import not_writable
    from tendond.offline.paper.published import published_for
    from tendond.offline.plots.report import write_report
    from tendond.offline.progress import working

    out = out or file.with_suffix(".html")
    try:
        with working(f"writing the report of {file.name}"):
            written = write_report(file, out, published_for)
    except OSError as error:
        raise not_writable(out, error) from error
    print(written)
