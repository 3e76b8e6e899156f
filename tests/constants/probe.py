"""The probe's constants, on right and wrong rigs of `tendond study wiring`.

A row counts the right rigs that pass and the wrong ones that are refused or in fault before the arm has moved far.
"""

import random
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor

from tendond.offline.wiring.study import CHAINS, Job, WiringOutcome, mistakes_of, run_job
from tests.constants.patch import changed, own_value
from tests.constants.values import Neighbours, in_words, print_table, values_of

PROBE: Neighbours = {
    "REST_BLOCK_SECONDS": (0.12, 0.5),
    "ENOUGH": (2, 10),
    "STILL": (0.005, 0.02),
    "TOGETHER": (0.002, 0.008),
    "AT_REST": (0.001, 0.004),
    "MOVED_AT_REST": (0.01, 0.04),
    "REST_LOAD_PART": (0.3, 1.0),
    "RELEASE_SECONDS": (0.2, 0.8),
    "SLACK_FACTOR": (0.5, 1.0, 4.0),
    "TAKE_UP": (2.0, 8.0),
    "DOWN_SECONDS": (0.06, 0.15),
    "START_SECONDS": (0.08, 0.32),
    "BLOCK_SECONDS": (0.05, 0.2),
    "STEADY": (0.07, 0.3),
    "STEADY_BLOCKS": (2, 8),
    "CLOSE": ((0.62, 1.5), (0.92, 1.1)),
    "MORE": (1.25, 2.0),
    "STOP_AT": (1.3, 2.0, 5.2),
    "DEAD": (0.12, 0.5),
}
"""Constants of `daemon.control.commissioning`, and values beside their own."""

LAW, SEED = "backstepping", 3
RIGHT_RIGS = 20
"""Right rigs, of either chain in turn."""

WRONG = {
    "axes mirrored": 4,
    "another robot, moving": 2,
    "tendons reversed": 3,
    "tendons in another order": 3,
    "tendons in another order and reversed": 2,
    "spools times 2": 2,
    "spools times 0.5": 2,
}
"""Kinds of mistakes that reach the probe, some of them at least, and number of each in either chain."""

TRACKING = 0.01
"""Time of tracking after which a rig counts as armed [s]."""

COLUMNS = "right rigs armed", "wrong rigs refused", "wrong rigs armed", "tip moved", "pulled", "probe s", "longest s"


def rigs() -> list[Job]:
    """List the rigs, the same for every value."""
    drawn = random.Random(SEED)
    wrong = []
    for chain in CHAINS:
        mistakes = mistakes_of(chain)
        for group, number in WRONG.items():
            kind = [index for index, mistake in enumerate(mistakes) if mistake.group == group]
            wrong += [Job(chain, LAW, index) for index in sorted(drawn.sample(kind, number))]
    chains = tuple(CHAINS)
    return wrong + [Job(chains[number % len(chains)], LAW, None, number) for number in range(RIGHT_RIGS)]


def run_rig(case: tuple[str, object, Job]) -> WiringOutcome:
    """Run one rig with one value, until it is armed."""
    name, value, job = case
    with changed(name, value):
        return run_job(job, TRACKING)


def probe_row(jobs: Sequence[Job], outcomes: Sequence[WiringOutcome]) -> list[str]:
    """Count what became of the rigs; what the worst wrong one did, and how long the probe of right ones took."""
    right = [one for job, one in zip(jobs, outcomes, strict=True) if job.mistake is None]
    wrong = [one for job, one in zip(jobs, outcomes, strict=True) if job.mistake is not None]
    seconds = sorted(one.probed for one in right if one.probed is not None)
    return [
        f"{sum(not one.noticed for one in right)} of {len(right)}",
        f"{sum(one.in_time for one in wrong)} of {len(wrong)}",
        f"{sum(not one.noticed for one in wrong)}",
        f"{1e2 * max(one.moved for one in wrong):.1f} %",
        f"{1e2 * max(one.pulled for one in wrong):.1f} %",
        f"{seconds[len(seconds) // 2]:.2f}" if seconds else "",
        f"{seconds[-1]:.2f}" if seconds else "",
    ]


def print_probe(names: Sequence[str], pool: Executor) -> None:
    """Print the table of the constants among `names`."""
    jobs, own = rigs(), {name: own_value(name) for name in PROBE}

    def rows() -> Iterator[list[str]]:
        for name, value in values_of(names, own, PROBE):
            outcomes = list(pool.map(run_rig, [(name, value, job) for job in jobs], chunksize=8))
            yield [name, in_words(value), *probe_row(jobs, outcomes)]

    print_table(("constant", "value", *COLUMNS), rows())
