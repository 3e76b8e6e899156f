"""Executors of points: processes of this computer, or a Dask cluster. The results are the same."""

import functools
import importlib.util
import multiprocessing
import multiprocessing.connection
import os
import signal
import threading
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import CancelledError, Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any, TypeVar

from tendond.daemon.errors import DaemonError
from tendond.model.warm import warm_up
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.points import Point
from tendond.offline.robustness.settings import SOURCES
from tendond.offline.source_hash import source_hash
from tendond.schemas.config.rig import RigConfig

CHUNK_POINTS = 2
"""Handed over at once: half a second of work, which is what an interruption can cost a process."""

CONNECT_SECONDS = 10
INSTALL = "pip install 'tendond[cluster]'"

Done = list[tuple[int, PointResult]]
Task = TypeVar("Task")
Outcome = TypeVar("Outcome")


class ExecutorError(DaemonError):
    """Points cannot be run there."""


@dataclass(frozen=True)
class Chunk:
    """Points to run one after the other, and all that they need; it travels between processes.

    Attributes:
        config: the controller's configuration, JSON.
        seed: the run's seed.
        points: points with their index in the run.
    """

    config: str
    seed: int
    points: tuple[tuple[int, Point], ...]


def chunks_of(config: RigConfig, seed: int, points: Sequence[tuple[int, Point]]) -> list[Chunk]:
    """Split points into chunks of `CHUNK_POINTS`, in their order."""
    text = config.model_dump_json()
    return [
        Chunk(text, seed, tuple(points[start : start + CHUNK_POINTS])) for start in range(0, len(points), CHUNK_POINTS)
    ]


def run_chunk(chunk: Chunk) -> Done:
    """Run a chunk, and return its results."""
    base = _config(chunk.config)
    return [(index, evaluate(base, point, chunk.seed)) for index, point in chunk.points]


@functools.lru_cache(maxsize=1)
def _config(text: str) -> RigConfig:
    return RigConfig.model_validate_json(text)


def in_processes(chunks: Sequence[Chunk], jobs: int) -> Generator[Done, None, None]:
    """Results as they come, from `jobs` processes of this computer; see `spread`."""
    yield from spread(run_chunk, chunks, jobs)


def spread(work: Callable[[Task], Outcome], tasks: Sequence[Task], jobs: int) -> Generator[Outcome, None, None]:
    """Yield each task's outcome as it comes, from `jobs` processes of this computer.

    Closing the iterator drops what has not begun, and waits for what has.

    Raises:
        ExecutorError: a process was killed.
    """
    # Spawned: this process may have threads, and a forked copy of a lock that one holds stays locked.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=_start_worker)
    try:
        # Processes are started by `submit`, and inherit the mask: Ctrl-C is for the one that waits for them.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            futures: list[Future[Outcome]] = [pool.submit(work, task) for task in tasks]
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for future in as_completed(futures):
            yield future.result()
    except BrokenProcessPool:
        raise ExecutorError("a worker process was killed; run the same command again to resume") from None
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _start_worker() -> None:
    """Kernels first; and without the process that waits for this one, this one ends."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    warm_up()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        multiprocessing.connection.wait([parent.sentinel])
        os._exit(1)


def check_cluster_extra() -> None:
    """Raise ExecutorError where Dask is not installed."""
    if importlib.util.find_spec("distributed") is None:
        raise ExecutorError(f"--cluster needs Dask, which is not installed: {INSTALL}")


def on_cluster(chunks: Sequence[Chunk], address: str) -> Generator[Done, None, None]:
    """Results as they come, from the workers of a Dask cluster, which must have this same tendond installed.

    Closing the iterator cancels what has not begun.

    Raises:
        ExecutorError: no Dask, no scheduler at `address`, no workers, or workers with another tendond.
    """
    check_cluster_extra()
    import distributed

    try:
        client = distributed.Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise ExecutorError(
            f"--cluster {address}: no Dask scheduler responds there ({_first_line(error)}); "
            "start one with 'dask scheduler' and give its address, for instance tcp://127.0.0.1:8786"
        ) from None
    futures = []
    try:
        _check_workers(client, address)
        futures = client.map(run_chunk, chunks, pure=False, retries=2)
        for future in distributed.as_completed(futures, loop=client.loop):
            yield future.result()
    except (OSError, TimeoutError, CancelledError, distributed.KilledWorker) as error:
        raise ExecutorError(
            f"--cluster {address}: lost ({_first_line(error)}); run the same command again to resume"
        ) from None
    finally:
        client.cancel(futures)
        client.close()


def _check_workers(client: Any, address: str) -> None:
    """Check that every worker has this version of tendond, and warm up its kernels."""
    ours = source_hash(SOURCES)
    try:
        theirs = client.run(_greet)
    except (OSError, ImportError, AttributeError) as error:
        raise ExecutorError(f"--cluster {address}: its workers cannot import tendond ({_first_line(error)})") from None
    if not theirs:
        raise ExecutorError(f"--cluster {address}: has no workers; start some with 'dask worker {address}'")
    for worker, version in theirs.items():
        if version != ours:
            raise ExecutorError(f"--cluster {address}: worker {worker} has another tendond; install this one there")


def _greet() -> str:
    warm_up()
    return source_hash(SOURCES)


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
