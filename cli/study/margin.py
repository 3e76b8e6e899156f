"""`tendond study margin`: tables as the rows are computed, then a summary."""

import json
import math
from dataclasses import asdict
from pathlib import Path

from tendond.cli.common import load_config
from tendond.offline.progress import tracked, working
from tendond.offline.robustness.margins.bent_stiffness import stiffness_rows
from tendond.offline.robustness.margins.filter_loop import FACTORS
from tendond.offline.robustness.margins.filter_map import FilterRow, filter_cases, filter_config, filter_rows
from tendond.offline.robustness.margins.loop import LoopRow, gains_rows, loop_cases, loop_rows


def run_margin(config_file: Path | None, as_json: bool, short: bool, processes: int) -> bool:
    """Print gains, stiffness of the bent arm and runs of the loop; return whether every run passes."""
    config = load_config(config_file)
    with working("computing the gains and the stiffness of the bent arm", quiet=as_json):
        gains, stiffnesses = list(gains_rows(config)), list(stiffness_rows(config))
    if not as_json:
        print("gains that the margin admits\n")
        print("| rate Hz | delay cycles | Li 1/s | Kp | Kd s | decay bare 1/s | decay loaded 1/s |")
        print("| --- | --- | --- | --- | --- | --- | --- |")
        for row in gains:
            print(
                f"| {row.rate:g} | {row.delay} | {row.integral:.2f} | {row.proportional:.2f} | {row.derivative:.3f} "
                f"| {row.bare:.2f} | {row.loaded:.2f} |"
            )
        print("\nstiffness of the tip in its min_stiffness_ratio direction, of 3 EI/L^3\n")
        print("| mass g | tension N | tip across mm | arm | observer |\n| --- | --- | --- | --- | --- |")
        for one in stiffnesses:
            print(
                f"| {one.mass * 1e3:.3g} | {one.tension:.3g} | {one.across * 1e3:.0f} | {one.arm:.2f} "
                f"| {one.observer:.2f} |"
            )
        print("\nthe loop in lockstep\n")
        print("| law | rate Hz | mass g | E | delay known | unknown | settling s | ripple mm | |")
        print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |", flush=True)
    runs: list[LoopRow] = []
    cases = list(loop_cases(config, short=short))
    for run in tracked(loop_rows(config, cases, processes), len(cases), "runs", quiet=as_json):
        runs.append(run)
        if not as_json:
            print(_line(run), flush=True)
    failed = sum(not run.passes for run in runs)
    if as_json:
        document = {
            "gains": [asdict(row) for row in gains],
            "stiffness": [asdict(row) for row in stiffnesses],
            "loop": [asdict(run) for run in runs],
            "failed": failed,
        }
        print(json.dumps(document, indent=2))
    else:
        worst = max((run.ripple for run in runs if run.ripple is not None), default=0.0)
        print(f"\n{len(runs) - failed} of {len(runs)} runs pass; largest ripple {worst * 1e3:.3f} mm")
    return failed == 0


def _line(run: LoopRow) -> str:
    settling = "-" if run.settling is None else f"{run.settling:.2f}"
    ripple = "-" if run.ripple is None else f"{run.ripple * 1e3:.3f}"
    verdict = "pass" if run.passes else f"FAIL {run.reason}".rstrip()
    return (
        f"| {run.law} | {run.rate:g} | {run.mass * 1e3:.3g} | {run.stiffness:g} "
        f"| {run.delay_known} | {run.delay_unknown} | {settling} | {ripple} | {verdict} |"
    )


FILTER_HEADS = (
    "law", "rate Hz", "delay ms", "bend rad", "law alone", "right plant", "worst plant", "decay 1/s", "mass g", "E",
    "late cycles", "gain margin",
)  # fmt: skip


def run_filter_margin(config_file: Path | None, as_json: bool, short: bool, processes: int) -> bool:
    """Print the poles of the loop with the filter over the workspace; return whether no motion grows."""
    config = filter_config(load_config(config_file))
    rows: list[FilterRow] = []
    if not as_json:
        print("poles of the loop with the filter, on the worst plant with an unknown mass, stiffness and delay\n")
        print(f"| {' | '.join(FILTER_HEADS)} |\n|{' --- |' * len(FILTER_HEADS)}", flush=True)
    cases = list(filter_cases(short=short))
    for row in tracked(filter_rows(config, cases, processes), len(cases), "rests", quiet=as_json):
        rows.append(row)
        if not as_json:
            print(_filter_line(row), flush=True)
    grown = sum(not row.passes for row in rows)
    if as_json:
        print(json.dumps({"poles": [asdict(row) for row in rows], "failed": grown}, indent=2))
    else:
        largest = max(row.worst for row in rows)
        least = min(row.margin for row in rows)
        print(f"\n{len(rows) - grown} of {len(rows)} rests pass; largest pole {largest:.5f}, gain margin {least:g}")
    return grown == 0


def _filter_line(row: FilterRow) -> str:
    case = row.case
    margin = f"{row.margin:g}" if math.isfinite(row.margin) else f"above {FACTORS[-1]:g}"
    return (
        f"| {case.law} | {case.rate:g} | {1e3 * case.delay:g} | {case.bend:g} | {row.own:.4f} | {row.nominal:.5f} "
        f"| {row.worst:.5f} | {row.decay:.3f} | {1e3 * row.mass:.3g} | {row.stiffness:g} | {row.late} | {margin} |"
    )
