"""`tendond try` as a process: output of all processes, the outcome, and Ctrl-C."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.sil.rig import PATIENCE_SECONDS, PATIENT
from tests.unit.cli.commands import TENDOND
from tests.unit.trying.test_task import LAB

pytestmark = pytest.mark.sil

QUICK = f"{LAB}{PATIENT}\n[commissioning]\nprobe = false\n[simulator.rod]\nyoungs_modulus = 195e9\n"


def begin(folder: Path, *more: str) -> "subprocess.Popen[str]":
    """Start a trial of the lab's rig, whose serial port and Zenoh file there are not."""
    (folder / "lab.toml").write_text(QUICK)
    return subprocess.Popen(
        [*TENDOND, "try", str(folder / "lab.toml"), "--out", str(folder / "out"), *more],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "ZENOH_CONFIG": str(folder / "the-rigs-own.json5")},
    )  # fmt: skip


def test_a_trial_prints_each_process_and_ends_with_the_outcome(tmp_path: Path) -> None:
    process = begin(tmp_path, "--time", "4")
    out, said = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 0, out + said
    lines = out.splitlines()
    assert {line.partition("|")[0].strip() for line in lines} == {
        "trial", "simulator", "controller", "operator", "report", "outcome",
    }  # fmt: skip
    assert any("no device or port of the rig is opened" in line for line in lines)
    unlike = [line for line in lines if "youngs_modulus = 1.95e+11, not 2e+11" in line]
    assert [line.partition("|")[0].strip() for line in unlike] == ["controller"], "once, by the process that noticed"
    assert lines[-1].startswith("outcome    | the tip rests at x ")
    for name in ("try.mcap", "report.html"):
        assert str(tmp_path / "out" / name) in lines[-1]
        assert (tmp_path / "out" / name).stat().st_size > 10_000


def test_ctrl_c_ends_all_processes_of_a_trial(tmp_path: Path) -> None:
    process = begin(tmp_path, "--time", "60")
    assert process.stdout is not None
    for line in process.stdout:
        if "tracking for" in line:
            break
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    assert len(children) == 2
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 130
    assert "controller | stopped; " in out, "it had released the tendons, and closed its log"
    assert not any(Path(f"/proc/{child}").exists() for child in children)


def test_a_trial_that_ends_in_a_fault_says_so_in_its_last_line_and_still_has_a_report(tmp_path: Path) -> None:
    hidden = "\n[simulator.mocap]\nocclusion = 100.0\nocclusion_time = 10.0\n"
    (tmp_path / "hidden.toml").write_text(
        f"[commissioning]\nprobe = false\nrest = false\n[faults]\npose_timeout = 0.2\n{hidden}"
    )
    ended = subprocess.run(
        [*TENDOND, "try", str(tmp_path / "hidden.toml"), "--out", str(tmp_path / "out"), "--time", "2"],
        capture_output=True, text=True, timeout=PATIENCE_SECONDS + 60, check=False,
    )  # fmt: skip
    assert ended.returncode == 1, ended.stdout
    last = ended.stdout.splitlines()[-1]
    assert last.startswith("outcome    | failed: the trial ")
    assert "report.html" in last
