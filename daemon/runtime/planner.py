"""A process that plans references beside the loop: planning takes seconds, and a cycle has milliseconds.

It is forked before the bus is opened and before any thread runs, so it has the setup and the compiled kernels. What it
plans is a pure function of setup, law and [reference]: a replay plans the same in the cycle itself, to the last bit.
"""

import os
import pickle
import signal
import struct
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import FrameType

from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.selection import select
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.errors import DaemonError, TargetError
from tendond.model.errors import ModelError
from tendond.schemas.config.reference import ReferenceSection

PLAN_SECONDS = 60.0
"""A reference that takes longer to plan is refused."""

NICENESS = 10
HEADER = struct.Struct("<Q")
PIECE = 1 << 18
"""Bytes that are taken over in a cycle."""


@dataclass(frozen=True)
class Plan:
    """The outcome of a request: the reference, or the reason why there is none."""

    law: str
    section: ReferenceSection
    reference: Reference | None
    error: str = ""


class Planner:
    """The planning process, seen from the loop: nothing here waits for it.

    Args:
        setup: setup of the cycle.
    """

    def __init__(self, setup: CycleSetup) -> None:
        context = get_context("fork")
        self._requests, theirs = context.Pipe()
        self._results, write = os.pipe()
        self._process = context.Process(
            target=_work, args=(setup, theirs, write, self._requests, self._results), daemon=True
        )
        # The process inherits the mask: it is ended by its parent, and must not run the parent's handlers before it
        # has its own. What comes to the parent meanwhile is kept.
        mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP, signal.SIGTERM})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        theirs.close()
        os.close(write)
        os.set_blocking(self._results, False)
        self._received = bytearray()
        self._busy = False
        self._gone = False
        self._wanted: tuple[str, ReferenceSection] | None = None

    def plan(self, law: str, section: ReferenceSection) -> None:
        """Ask for a plan; one that is asked for already is given up."""
        self._wanted = (law, section)
        self._begin()

    def give_up(self) -> None:
        """Want no plan any more; what the process is computing is discarded."""
        self._wanted = None

    def poll(self) -> Plan | None:
        """The plan that was asked for last, once it is there; never blocks."""
        if self._gone:
            return self._lost()
        if not self._busy:
            return None
        try:
            piece = os.read(self._results, PIECE)
        except BlockingIOError:
            return None
        if not piece:
            self._gone = True
            return self._lost()
        self._received += piece
        if len(self._received) < HEADER.size:
            return None
        (size,) = HEADER.unpack_from(self._received)
        if len(self._received) < HEADER.size + size:
            return None
        plan: Plan = pickle.loads(memoryview(self._received)[HEADER.size :])
        self._received, self._busy = bytearray(), False
        if self._wanted != (plan.law, plan.section):
            self._begin()
            return None
        self._wanted = None
        return plan

    def _begin(self) -> None:
        if self._wanted is None or self._busy or self._gone:
            return
        try:
            self._requests.send(self._wanted)
            self._busy = True
        except OSError:
            self._gone = True

    def _lost(self) -> Plan | None:
        """The reply to a plan that will not come."""
        if self._wanted is None:
            return None
        (law, section), self._wanted = self._wanted, None
        return Plan(law, section, None, "the planning process has ended; restart the controller")

    def close(self) -> None:
        """End the process."""
        self._requests.close()
        os.close(self._results)
        self._process.terminate()
        self._process.join()


def _work(setup: CycleSetup, requests: Connection, results: int, *theirs: "Connection | int") -> None:
    """Plan what is asked for, until the loop's process is gone."""
    for end in theirs:  # else this process would keep its own pipes open
        os.close(end if isinstance(end, int) else end.fileno())
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    signal.signal(signal.SIGALRM, _too_long)
    os.nice(NICENESS)
    with suppress(EOFError, OSError):
        while True:
            law, section = requests.recv()
            signal.setitimer(signal.ITIMER_REAL, PLAN_SECONDS)
            plan = make_plan(setup, law, section)
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            data = pickle.dumps(plan)
            _write(results, HEADER.pack(len(data)) + data)
    os._exit(0)  # nothing of the loop's process is to be cleaned up here


def make_plan(setup: CycleSetup, law: str, section: ReferenceSection) -> Plan:
    """Plan a reference for a law; whatever goes wrong is the plan's error."""
    try:
        selection = select(setup.config, setup.rod, law, section, setup.selection.curve)
        return Plan(law, section, selection.reference)
    except (DaemonError, ModelError) as error:
        return Plan(law, section, None, "; ".join(str(error).splitlines()))
    except Exception as error:
        return Plan(law, section, None, f"planning failed: {type(error).__name__}: {error}")


def _too_long(number: int, frame: FrameType | None) -> None:
    raise TargetError(f"planning it takes more than {PLAN_SECONDS:g} s: ask for fewer laps or samples")


def _write(pipe: int, data: bytes) -> None:
    view = memoryview(data)
    while view:
        view = view[os.write(pipe, view) :]
