"""`tendond warm`: what it compiles, what it says, and how it ends."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tendond.daemon.errors import DaemonError
from tendond.offline import kernels
from tendond.schemas.config.rig import check_config

WARM = [sys.executable, "-m", "tendond.cli", "warm"]


def children_of(pid: int) -> list[int]:
    """List the processes that this one has started."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            found += [int(entry.name)] * (parent == pid)
    return found


def test_ctrl_c_ends_the_compilation_without_a_traceback_and_leaves_no_process(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    with subprocess.Popen(WARM, stderr=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stderr is not None
        first = process.stderr.readline()
        assert first.startswith("tendond: compiling the kernels of the ")
        compiling = children_of(process.pid)
        assert len(compiling) == 2
        process.send_signal(signal.SIGINT)
        rest = process.stderr.read()
    assert process.returncode == 130
    assert "Traceback" not in rest
    assert not any(Path(f"/proc/{pid}").exists() for pid in compiling)


def test_compiled_kernels_are_loaded_in_silence() -> None:
    subprocess.run(WARM, check=True)
    found = subprocess.run(WARM, capture_output=True, text=True, check=True)
    assert found.stdout == found.stderr == ""


@pytest.mark.parametrize(
    ("robot", "parts"),
    [({}, {"shooting", "general"}), ({"preset": "rao-2021"}, {"general"})],
    ids=["paper", "two sections"],
)
def test_a_configuration_needs_the_kernels_of_its_rods(robot: dict[str, str], parts: set[str]) -> None:
    config = check_config({"rod": robot, "reference": {"across": 0.1}}, "test")
    assert {part[0] for part in kernels.parts_of(config)} == parts


def test_a_failed_process_is_reported_with_its_last_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(kernels.NAMES, "absent", "absent rod")
    with pytest.raises(DaemonError, match="kernels of the absent rod could not be compiled: KeyError: 'absent'"):
        kernels.compile_kernels([["absent"]], 4, lambda name, count, function: None)
