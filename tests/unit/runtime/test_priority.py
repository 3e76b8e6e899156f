"""A driver goes before everything but the loop, with the threads that it starts, or says that it may not."""

import subprocess
import sys

import pytest

CODE = """
import os, resource, threading
from tendond.daemon.runtime.realtime import keep_up
from tendond.schemas.config.control import LoopSection

if LIMITED:
    resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
    os.setgroups([])
    os.setuid(65534)
missing = keep_up(LoopSection(priority=PRIORITY))
found = []
thread = threading.Thread(target=lambda: found.append(os.sched_getparam(0).sched_priority))
thread.start()
thread.join()
print(os.sched_getparam(0).sched_priority, *found, *missing)
"""


def said(priority: int, limited: bool) -> str:
    code = CODE.replace("PRIORITY)", f"{priority})").replace("LIMITED", str(limited))
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


@pytest.mark.parametrize(("priority", "expected"), [(50, 49), (2, 1), (1, 0), (0, 0)])
def test_the_priority_is_just_below_the_loop_s(priority: int, expected: int) -> None:
    found = said(priority, limited=False)
    if "no FIFO" in found:
        pytest.skip(f"not permitted here: {found}")
    assert found == f"{expected} {expected}"


def test_what_is_not_permitted_is_said() -> None:
    try:
        found = said(50, limited=True)
    except subprocess.CalledProcessError:
        pytest.skip("another user cannot be taken here, or cannot read the project")
    assert found == "0 0 no FIFO priority 49 (Operation not permitted; LimitRTPRIO=49)"
