"""All runs of the study of contacts, in parallel processes."""

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache

from tendond.offline.contact.cases import PERIOD, Case, contact_cases, free_cases
from tendond.offline.contact.run import Outcome, Setting

FREE_SECONDS = 60.0
"""Time of a run without a contact [s]."""

Job = tuple[Case, int]


def jobs(runs: int, minutes: int, seed: int) -> list[Job]:
    """Return the runs: so many of each case with a contact, and minutes of each case without one."""
    some = [(case, seed + index) for case in contact_cases() for index in range(runs)]
    return some + [(case, seed + index) for case in free_cases() for index in range(minutes)]


@cache
def _setting(case: Case) -> Setting:
    return Setting(case)


def run_job(job: Job) -> Outcome:
    """Run one."""
    case, seed = job
    return _setting(case).run(seed, None if case.force else round(FREE_SECONDS / PERIOD))


def run_jobs(some: list[Job], processes: int | None) -> Iterator[Outcome]:
    """Yield the outcomes in the order of the jobs."""
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(run_job, some)
