"""Run the closed loop of `daemon.control.cycle` and the MuJoCo plant over a grid of weights on the tip.

A rigid body that the controller knows nothing of hangs on the tip from the start; the plant's E is not the model's; the
poses are delayed, and the delay is configured or not. `python -m tests.plants.weights` prints a row for each run, and
exits with 1 where one falls short: not settled, or a ripple above 0.2 mm.
"""

import argparse
import itertools
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, fields

from tests.plants.weight_run import TRACKING, WINDOW, Case, Outcome, run

LAWS = ("backstepping", "sliding_mode", "sensitivity")
RATES = (100, 250)
MASSES = (0.0, 20.0, 35.0, 50.0, 100.0)
STIFFNESSES = (0.85, 1.0, 1.15)
DELAYS = ((0, 0), (1, 0), (2, 0), (3, 0), (0, 1))
"""(known_delay, unknown_delay), in cycles."""


SHORT = (
    Case(mass=0.0),
    Case(mass=35.0),
    Case(mass=50.0),
    Case(mass=100.0),
    Case(mass=35.0, stiffness=0.85, known_delay=2),
    Case(mass=50.0, stiffness=0.85, unknown_delay=1),
    Case(mass=100.0, stiffness=0.85, known_delay=3),
    Case(mass=35.0, stiffness=1.15, unknown_delay=1, law="sliding_mode"),
    Case(mass=50.0, rate=250, stiffness=0.85, known_delay=3, law="sliding_mode"),
    Case(mass=20.0, law="sensitivity"),
    Case(mass=35.0, stiffness=0.85, unknown_delay=1, law="sensitivity"),
    Case(mass=100.0, rate=250, stiffness=0.85, known_delay=3, law="sensitivity"),
)
"""Cases of the report, and corners of the grid."""


def grid() -> Iterator[Case]:
    """Yield all cases."""
    for rate, law, mass, stiffness, (known_delay, unknown_delay) in itertools.product(
        RATES, LAWS, MASSES, STIFFNESSES, DELAYS
    ):
        yield Case(
            law=law, rate=rate, mass=mass, stiffness=stiffness, known_delay=known_delay, unknown_delay=unknown_delay
        )


HEADING = (
    f"{'law':12} {'Hz':>3} {'drive':>7} {'g':>4} {'E':>5} {'Bbt':>4} {'known':>5} {'unknown':>7}  {'settled s':>9} "
    f"{'ripple mm':>9} {'error mm':>8} {'max N':>6}"
)


def line(case: Case, outcome: Outcome) -> str:
    """Return a row of the table."""

    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    return (
        f"{case.law:12} {case.rate:3d} {case.drive[:7]:>7} {case.mass:4.0f} {case.stiffness:5.2f} {case.damping:4.1f} "
        f"{case.known_delay:5d} {case.unknown_delay:7d}  {number(outcome.settling, '.2f'):>9} "
        f"{number(outcome.ripple, '.3f'):>9} {number(outcome.error, '.2f'):>8} {outcome.tension:6.1f}  "
        f"{'ok' if outcome.passed else 'FALLS SHORT ' + outcome.reason}".rstrip()
    )


def summary(outcomes: Sequence[tuple[Case, Outcome]]) -> Iterator[str]:
    """Yield a table of the outcomes by law and rate, as Markdown."""
    yield "| law | loop [Hz] | runs | settled, ripple <= 0.2 mm | largest ripple [mm] | slowest [s] |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for law, rate in dict.fromkeys((case.law, case.rate) for case, _ in outcomes):
        some = [outcome for case, outcome in outcomes if (case.law, case.rate) == (law, rate)]
        ripples = [outcome.ripple for outcome in some if outcome.ripple is not None]
        times = [outcome.settling for outcome in some if outcome.settling is not None]
        yield (
            f"| {law} | {rate} | {len(some)} | {sum(outcome.passed for outcome in some)} "
            f"| {max(ripples, default=math.nan):.3f} | {max(times, default=math.nan):.2f} |"
        )


def main(arguments: list[str] | None = None) -> int:
    """Run the grid, or the part of it that the options name; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.plants.weights", description=__doc__)
    parser.add_argument("--short", action="store_true", help=f"run a selection of {len(SHORT)} cases only")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all processors)")
    parser.add_argument(
        "--tracking", type=float, default=TRACKING, help=f"time of tracking in a run [s] (default: {TRACKING:g})"
    )
    for field in fields(Case):
        kind = type(field.default)
        parser.add_argument(
            f"--{field.name.replace('_', '-')}", type=kind, nargs="+", help="only these, or for all if none has them"
        )
    options = parser.parse_args(arguments)
    if options.tracking <= WINDOW:
        parser.error(f"--tracking {options.tracking:g}: longer than {WINDOW:g} s, over which the ripple is taken")
    cases = list(SHORT if options.short else grid())
    for field in fields(Case):
        only = getattr(options, field.name)
        if only is not None:
            kept = [case for case in cases if getattr(case, field.name) in only]
            cases = kept or list(
                dict.fromkeys(Case(**{**asdict(case), field.name: value}) for case in cases for value in only)
            )
    if not options.json:
        print(HEADING, flush=True)
    outcomes: list[tuple[Case, Outcome]] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        for case, outcome in zip(cases, pool.map(run, cases, itertools.repeat(options.tracking)), strict=True):
            outcomes.append((case, outcome))
            text = json.dumps({**asdict(case), **asdict(outcome)}) if options.json else line(case, outcome)
            print(text, flush=True)
    if not options.json:
        print("", *summary(outcomes), sep="\n")
    return 0 if all(outcome.passed for _, outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
