"""Independent jobs on two processors."""

import multiprocessing
import os
import signal
import warnings
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from typing import Any, TypeVar

T = TypeVar("T")


def in_parallel(jobs: Sequence[Callable[[], T]]) -> list[T]:
    """Run jobs, each once, some of them in a second process; return their results in order.

    The second process is a copy of this one (fork), which has what is imported and read already. A job that fails
    there, or whose result does not come back, is run here again, so that an error is raised as if there were one
    process. Without a second processor, all are run here.

    Args:
        jobs: functions without side effects but on files of their own, whose results can be pickled.
    """
    if len(jobs) < 2 or len(os.sched_getaffinity(0)) < 2:
        return [job() for job in jobs]
    fork = multiprocessing.get_context("fork")
    try:
        taken = fork.Value("i", 0)
    except OSError:  # a machine without shared memory
        return [job() for job in jobs]
    ours, theirs = fork.Pipe(duplex=False)

    def take() -> int:
        with taken:
            taken.value += 1
            return int(taken.value) - 1

    helper = fork.Process(target=_help, args=(jobs, take, theirs), daemon=True)
    with warnings.catch_warnings():
        # From 3.12 on, of a fork beside threads: those here print progress or wait for the bus; the copy needs neither.
        warnings.simplefilter("ignore", DeprecationWarning)
        helper.start()
    theirs.close()
    done: dict[int, T] = {}
    try:
        while (number := take()) < len(jobs):
            done[number] = jobs[number]()
        done |= _received(ours)
    finally:
        ours.close()
        helper.terminate()
        helper.join()
    return [done[number] if number in done else job() for number, job in enumerate(jobs)]


def _help(jobs: Sequence[Callable[[], Any]], take: Callable[[], int], results: Connection) -> None:
    """Run jobs in the second process; one that fails is left to the first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the terminal's Ctrl-C: the first process ends this one
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    done: dict[int, Any] = {}
    while (number := take()) < len(jobs):
        try:
            done[number] = jobs[number]()
        except Exception:  # whatever it is, the first process meets it again, and says so
            continue
    results.send(done)


def _received(results: Connection) -> dict[int, Any]:
    try:
        found: dict[int, Any] = results.recv()
    except (EOFError, OSError):  # it was killed
        return {}
    return found
