"""`tendond study robustness` on real processes: a Dask cluster beside the process pool, and an end without warning."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

PATIENCE_SECONDS = 400.0
"""Time for a study of a few points, at a low priority on a busy machine [s]."""

COUNT = 5
POINTS = ("--points", "sample", "--count", str(COUNT), "--law", "backstepping", "--seed", "5")


def start(*arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(arguments, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def robustness(out: Path, *more: str) -> subprocess.Popen[str]:
    return start(sys.executable, "-m", "tendond.cli", "study", "robustness", "--out", str(out), *POINTS, *more)


def finish(process: subprocess.Popen[str]) -> str:
    said, _ = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 0, said
    return said


@pytest.fixture(scope="module")
def pooled(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """CSV of the process pool."""
    out = tmp_path_factory.mktemp("pool")
    finish(robustness(out, "--jobs", "2"))
    assert {file.name for file in out.iterdir()} == {
        "results.csv",
        "summary.json",
        "report.md",
        "heatmap.png",
        "results.jsonl",
    }
    return (out / "results.csv").read_bytes()


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[str]:
    """Address of a scheduler on loopback with two workers."""
    file = tmp_path / "scheduler.json"
    processes = [
        start(*scheduler_command(file)),
        *(start(*worker_command(file, tmp_path / name)) for name in ("a", "b")),
    ]
    try:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not file.exists() or not file.read_text().strip():
            assert processes[0].poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
        yield json.loads(file.read_text())["address"]
    finally:
        for process in processes:
            process.kill()
            process.communicate()


def scheduler_command(file: Path) -> tuple[str, ...]:
    options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show", "--scheduler-file", str(file))
    return (sys.executable, "-m", "distributed.cli.dask_scheduler", *options)


def worker_command(file: Path, folder: Path) -> tuple[str, ...]:
    options = ("--host", "127.0.0.1", "--nthreads", "1", "--no-nanny", "--no-dashboard", "--local-directory")
    return (sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file), *options, str(folder))


def test_a_cluster_of_two_workers_gives_the_process_pools_bytes(tmp_path: Path, cluster: str, pooled: bytes) -> None:
    finish(robustness(tmp_path / "out", "--cluster", cluster))
    assert (tmp_path / "out" / "results.csv").read_bytes() == pooled


def test_a_run_that_is_ended_twice_goes_on_to_the_same_bytes(tmp_path: Path, pooled: bytes) -> None:
    said, kept = ended(tmp_path, signal.SIGINT, 1)
    assert f"interrupted: {kept} of {COUNT} points are kept in {tmp_path}" in said
    ended(tmp_path, signal.SIGKILL, kept + 1)
    assert not (tmp_path / "results.csv").exists()
    finish(robustness(tmp_path, "--jobs", "1"))
    assert (tmp_path / "results.csv").read_bytes() == pooled


def ended(out: Path, number: int, after: int) -> tuple[str, int]:
    """Start a run, end it once its results file has so many points; what it said, and how many are kept."""
    results = out / "results.jsonl"
    process = robustness(out, "--jobs", "1")
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not results.exists() or results.read_bytes().count(b"\n") < 1 + after:
        assert process.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.005)
    workers = children(process.pid)
    assert workers
    process.send_signal(number)
    said, _ = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == (130 if number == signal.SIGINT else -number)
    while any(is_alive(worker) for worker in workers):  # they do not outlive it
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return said, results.read_bytes().count(b"\n") - 1


def children(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in text.split()]


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
