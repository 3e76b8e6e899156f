"""Every cycle of a log computed again, through the `cycle.step` that ran live, and compared with what was recorded."""

import os
import time
from collections import deque
from collections.abc import Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import chain, islice
from multiprocessing import get_context
from pathlib import Path

from pydantic import BaseModel, ValidationError

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState, initial_state
from tendond.daemon.errors import DaemonError
from tendond.daemon.runtime.warm_up import warm_up
from tendond.model import ModelError
from tendond.offline.logs.container import LogError
from tendond.offline.logs.run import Run, no_cycles, open_run
from tendond.offline.replay.difference import Difference, Field, compare
from tendond.offline.replay.segments import Gaps, Segment, segments
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.record import RECORD_VERSION, CycleInputs, CycleRecord

ALONE = 8
"""Segments below which a log is not worth other processes."""


BEFORE_INPUTS, AFTER_INPUTS = b',"inputs":', b',"rejected":['
"""Bytes before and after the inputs in a record; no text can contain these: its quotes are escaped."""


class RecordedInputs(BaseModel):
    """The inputs of a record."""

    inputs: CycleInputs


@dataclass
class ReplayOutcome:
    """Result of a replay.

    Attributes:
        compared: cycles that were computed again and compared.
        differing: those that differ.
        first: the first of these, with each field that differs.
        period: period of the cycle [s].
        seconds: time that the replay took, once code and kernels were loaded.
        gaps: gaps in the log.
        complete: the log was finished.
    """

    compared: int = 0
    differing: int = 0
    first: Difference | None = None
    period: float = 0.0
    seconds: float = 0.0
    gaps: Gaps = field(default_factory=Gaps)
    complete: bool = True

    @property
    def speed(self) -> float:
        """Times real time."""
        return self.compared * self.period / self.seconds


def rerun(
    path: Path,
    *,
    first: int = 0,
    last: int | None = None,
    tolerance: float | None = None,
    jobs: int | None = None,
) -> ReplayOutcome:
    """Run a log again and compare every output.

    Args:
        path: the log, or a part of it.
        first, last: ticks to compare, both included.
        tolerance: see `compare`; None: equal bytes.
        jobs: processes; none: one per processor, for logs that are worth it.

    Raises:
        LogError: the log cannot be used, or nothing in it could be compared.
    """
    run = open_run(path)
    setup = recorded_setup(run.config, str(run.paths[0]))
    warm_up(setup)  # loads the kernels: not a part of the replay's time
    outcome = ReplayOutcome(period=run.config.loop.period)
    started = time.perf_counter()
    for compared, differing, difference in _results(run, setup, outcome.gaps, first, last, tolerance, jobs):
        outcome.compared += compared
        outcome.differing += differing
        outcome.first = outcome.first or difference
    outcome.seconds = time.perf_counter() - started
    outcome.complete = run.complete or last is not None  # up to `last`
    if not outcome.compared:
        if first == 0 and last is None and not outcome.gaps.passed_over:
            raise no_cycles(path)
        raise LogError(
            f"{path}: no cycle could be compared: the log has no cycle between {first} and "
            f"{'its end' if last is None else last} with a state before it; choose others"
        )
    return outcome


def recorded_setup(config: RigConfig, source: str) -> CycleSetup:
    """Return the setup of the configuration in a log, whose file is `source`.

    Raises:
        LogError: this version of tendond cannot use it.
    """
    try:
        return CycleSetup.from_config(config)
    except (DaemonError, ModelError, ConfigError) as error:
        line = "; ".join(str(error).splitlines())
        raise LogError(f"{source}: {line}; replay it with the version of tendond that wrote it") from error


@dataclass
class Reached:
    """A state that a replay has come to, and its text, which is that of the log. The next segment begins with it."""

    text: str | None = None
    state: CycleState | None = None


Result = tuple[int, int, Difference | None]
_setup: CycleSetup


def _results(
    run: Run, setup: CycleSetup, gaps: Gaps, first: int, last: int | None, tolerance: float | None, jobs: int | None
) -> Iterator[Result]:
    """Yield the result of each segment, in order."""
    pieces = segments(run, gaps, first, last)
    head = list(islice(pieces, ALONE))
    jobs = jobs or len(os.sched_getaffinity(0))
    if jobs == 1 or len(head) < ALONE:
        reached = Reached()
        for piece in chain(head, pieces):
            yield run_segment(setup, piece, tolerance, reached)
        return
    # Forked, so that kernels and setup are there already.
    with ProcessPoolExecutor(jobs, get_context("fork"), _begin, (setup,)) as pool:
        waiting: deque[Future[Result]] = deque()
        for piece in chain(head, pieces):
            waiting.append(pool.submit(_run_segment, piece, tolerance))
            if len(waiting) > 4 * jobs:  # no more of the log in memory than that
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()


def _begin(setup: CycleSetup) -> None:
    global _setup
    _setup = setup


def _run_segment(segment: Segment, tolerance: float | None) -> Result:
    return run_segment(_setup, segment, tolerance, Reached())


def run_segment(setup: CycleSetup, segment: Segment, tolerance: float | None, reached: Reached) -> Result:
    """Replay a segment: the cycles compared, those that differ, and where the first of these does.

    Without a tolerance the state at the end must be the one in the log, too: then what follows from it is checked by
    what follows it, and `reached` is what the next segment can begin with.
    """
    known = reached.state is not None and reached.text == segment.start
    state = reached.state if known and reached.state is not None else state_before(setup, segment)
    reached.state = None
    compared = differing = 0
    found: Difference | None = None
    for i, data in enumerate(segment.cycles):
        try:
            state, _, record = step(setup, state, inputs_of(data))
        except Exception as error:  # another version's cycle may fail on this log: that is a finding
            failure = Field("(all)", "a record", f"{type(error).__name__}: {error}")
            return compared + 1, differing + 1, found or Difference(segment.first + i, (failure,))
        if i < segment.skip:
            continue
        compared += 1
        again = record.model_dump_json().encode()
        if again != data and (fields := compare(_present_record(data), again, tolerance)):
            differing += 1
            found = found or Difference(segment.first + i, fields)
    if found is not None or tolerance is not None or segment.end is None:
        return compared, differing, found
    text = encode_state(state)
    if text != segment.end and (fields := compare(_with_present_names(setup, segment.end), text)):
        fields = tuple(Field(f"state.{one.path}", one.logged, one.replayed) for one in fields)
        return compared, 1, Difference(state.tick - 1, fields)
    reached.text, reached.state = segment.end, state
    return compared, differing, found


def _with_present_names(setup: CycleSetup, text: str) -> str:
    """Return a state's text as this version writes it, where an older one has written it; else as it is."""
    with suppress(ValueError):
        return encode_state(decode_state(CycleState, text, setup))
    return text


def _present_record(data: bytes) -> bytes:
    """Return a record as this version writes it, where version 1 has written it; else as it is."""
    if not data.startswith(b'{"version":1,'):
        return data
    record = CycleRecord.model_validate_json(data).model_copy(update={"version": RECORD_VERSION})
    return record.model_dump_json().encode()


def inputs_of(data: bytes) -> CycleInputs:
    """Parse the inputs of a record; the rest is neither parsed nor validated.

    Raises:
        ValidationError: the record has no valid inputs.
    """
    start, end = data.find(BEFORE_INPUTS), data.find(AFTER_INPUTS)
    if start >= 0 and end >= 0:
        with suppress(ValidationError):  # not as the recorder writes it: parse it fully
            return CycleInputs.model_validate_json(data[start + len(BEFORE_INPUTS) : end])
    return RecordedInputs.model_validate_json(data).inputs


def state_before(setup: CycleSetup, segment: Segment) -> CycleState:
    """Return the state with which a segment begins.

    Raises:
        LogError: it is of another version.
    """
    if segment.start is None:
        return initial_state(setup)
    try:
        return decode_state(CycleState, segment.start, setup)
    except ValueError as error:
        raise LogError(
            f"the state before cycle {segment.first} {error}; replay it with the version that wrote it"
        ) from None
