"""Jobs on two processors: each once, in order, with errors as from one process."""

import os
import signal
import time
from functools import partial
from pathlib import Path

import pytest

from tendond.offline.parallel import in_parallel

needs_two = pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one processor: all jobs run in one process")


def noted(folder: Path, number: int) -> tuple[int, int]:
    """Leave a file, which must not be there yet, and return the number and the process."""
    with open(folder / str(number), "x", encoding="utf-8"):
        time.sleep(0.05)
    return number, os.getpid()


@needs_two
def test_two_processes_share_the_jobs_and_run_each_once(tmp_path: Path) -> None:
    results = in_parallel([partial(noted, tmp_path, number) for number in range(8)])
    assert [number for number, _ in results] == list(range(8))
    assert len({process for _, process in results}) == 2
    assert len(list(tmp_path.iterdir())) == 8


@pytest.mark.parametrize("failing", range(3))
def test_an_error_is_that_of_the_job_wherever_it_ran(failing: int, tmp_path: Path) -> None:
    def job(number: int) -> int:
        time.sleep(0.05)
        if number == failing:
            raise FileNotFoundError(f"number {number}")
        return number

    with pytest.raises(FileNotFoundError, match=f"number {failing}"):
        in_parallel([partial(job, number) for number in range(3)])


@needs_two
def test_what_a_killed_process_had_done_is_done_again() -> None:
    first = os.getpid()

    def job(number: int) -> int:
        time.sleep(0.05)
        if os.getpid() != first:
            os.kill(os.getpid(), signal.SIGKILL)
        return number

    assert in_parallel([partial(job, number) for number in range(4)]) == list(range(4))


def test_on_one_processor_all_jobs_run_in_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0})
    assert in_parallel([os.getpid] * 3) == [os.getpid()] * 3
    assert in_parallel([]) == []
