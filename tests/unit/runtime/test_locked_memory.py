"""Locked memory: what the loop touches stays, what is only reserved takes none."""

import subprocess
import sys

import pytest

CODE = """
import mmap, re
from pathlib import Path
from tendond.daemon.runtime.realtime import become_punctual
from tendond.schemas.config.control import LoopSection

def locked():
    text = Path("/proc/self/smaps_rollup").read_text()
    return int(re.search(r"^Locked: +(\\d+) kB", text, re.M).group(1)) >> 10

refused = become_punctual(LoopSection(priority=0, lock_memory=LOCK))
before, reserved = locked(), mmap.mmap(-1, 256 << 20)
untouched = locked()
for page in range(0, 64 << 20, mmap.PAGESIZE):
    reserved[page] = 1
print(bool(refused), before > 0, untouched - before, locked() - untouched)
"""


@pytest.mark.parametrize("lock", [True, False])
def test_what_is_touched_is_locked_and_what_is_reserved_is_not(lock: bool) -> None:
    code = CODE.replace("LOCK", str(lock))
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    if found[0] == "True":  # not permitted here: said so, and nothing is locked
        lock = False
    assert found[1] == str(lock)
    assert int(found[2]) < 16
    assert int(found[3]) >= 60 if lock else int(found[3]) == 0
