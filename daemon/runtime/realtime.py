"""Operating system settings for the loop's punctuality, each where it is permitted; a line where it is not."""

import ctypes
import gc
import os
import resource
import sys
import threading
from contextlib import suppress
from pathlib import Path

from tendond.schemas.config.control import LoopSection

MCL_CURRENT, MCL_FUTURE, MCL_ONFAULT = 1, 2, 4
CAP_IPC_LOCK = 14
PR_SET_TIMERSLACK = 29

SWITCH_SECONDS = 0.5e-3
"""Longest time for which the recorder's thread keeps the interpreter from the loop [s]; Python's default is 5 ms."""


def become_punctual(section: LoopSection) -> list[str]:
    """Lock memory, take FIFO priority and one CPU, and freeze the garbage collector.

    Python's other threads that exist already (the recorder's) get the lowest such priority, Zenoh's keep theirs: the
    loop goes before them.

    Args:
        section: [loop].

    Returns:
        What was not permitted, in words.
    """
    missing = []
    be_prompt()
    gc.collect()
    gc.freeze()
    if section.lock_memory and not _lock_memory():
        missing.append("memory is not locked (LimitMEMLOCK=infinity)")
    if section.cpu is not None:
        try:
            os.sched_setaffinity(0, {section.cpu})
        except OSError as error:
            missing.append(f"not bound to loop.cpu = {section.cpu} ({error.strerror})")
    if section.priority:
        try:
            policy = os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
            os.sched_setscheduler(0, policy, os.sched_param(section.priority))
            # The recorder holds the interpreter now and then: whoever kept it from running then would hold up the loop.
            for thread in threading.enumerate():
                if thread is not threading.current_thread() and thread.native_id is not None:
                    os.sched_setscheduler(thread.native_id, policy, os.sched_param(1))
        except OSError as error:
            missing.append(f"no FIFO priority {section.priority} ({error.strerror}; LimitRTPRIO={section.priority})")
    return missing


def keep_up(section: LoopSection) -> list[str]:
    """Give this process, with all threads that it starts from now on, the FIFO priority just below the loop's.

    For drivers, and for simulated robots, which wait for a busy computer no more than real ones. Call it once kernels
    are loaded: to compile them so would take a processor from everything else.

    Args:
        section: [loop]; a priority of 0 or 1 leaves none below it, and is not an error.

    Returns:
        What was not permitted, in words.
    """
    be_prompt()
    if section.priority <= 1:
        return []
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(section.priority - 1))
    except OSError as error:
        return [f"no FIFO priority {section.priority - 1} ({error.strerror}; LimitRTPRIO={section.priority - 1})"]
    return []


def be_prompt() -> None:
    """Short sleeps of the calling thread end when they should, and the recorder hands the interpreter over at once.

    Linux else adds up to 50 us to a sleep, but for FIFO threads; Python waits for 5 ms.
    """
    sys.setswitchinterval(SWITCH_SECONDS)
    with suppress(OSError, AttributeError):  # a system without it sleeps as it does
        ctypes.CDLL(None).prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)


def _lock_memory() -> bool:
    """Lock every page that the process has touched or will touch: none is fetched from the disk a second time.

    What is only reserved, such as stacks and arenas of Zenoh's threads, takes none. Under a limit it is not tried: with
    MCL_FUTURE an allocation beyond the limit would fail, in the middle of a run.
    """
    unlimited = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY
    if not (unlimited or _has_capability(CAP_IPC_LOCK)):
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    return bool(libc.mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0)


def _has_capability(bit: int) -> bool:
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return False
    (mask,) = (line.split()[1] for line in status.splitlines() if line.startswith("CapEff:"))
    return bool(int(mask, 16) >> bit & 1)
