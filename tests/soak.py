"""Long runs, by hand: memory over lockstep cycles, and a real-time run that loses nothing.

    python -m tests.soak cycles 1000000     closed loop in this process, log and all; resident memory as it goes
    python -m tests.soak minutes 10         controller and simulator as processes, in real time, tracking

Both print a line of JSON; the second a verdict as well. Exit status 1 where a promise is broken.
"""

import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.offline.logs.log import load
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, LoopTiming
from tendond.schemas.requests import ControlAction
from tests.sil.rig import rig

MEGABYTE = 1e6
FLAT = 2.0 * MEGABYTE
WARM = 0.1
"""Part of a run after which memory must not grow."""

ALONE = 1.0
"""Deadlines per minute that it may miss alone: a stall of one processor does not reach who is on the other."""

SPLIT = "[log]\nsplit_size = 20.0\n"


def resident() -> float:
    """Memory of this process [bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) * 1024.0
    raise OSError("no VmRSS")


def lockstep(cycles: int) -> bool:
    """Closed loop with arming, stopping and resting in turn; memory every hundredth."""
    config = parse_config(SPLIT, "soak")
    setup = CycleSetup.from_config(config)
    plant = Plant(config, rod_from_section(config.simulator.rod, config.loop.period))
    state, memory = initial_state(setup), []
    gc.collect()
    gc.freeze()
    gc.disable()  # as in the loop
    started = time.monotonic()
    with tempfile.TemporaryDirectory() as folder, RunLog(Path(folder) / "soak.mcap", config, setup.rod) as run_log:
        for tick in range(cycles):
            pose, tendons, truth = plant.observe(0)
            request = {5: ControlAction.ARM, 3000: ControlAction.STOP}.get(tick % 4000)
            inputs = CycleInputs(pose=pose, tendon_state=tendons, request=request)
            state, command, record = step(setup, state, inputs)
            timing = LoopTiming(tick=tick, lateness_us=0.0, work_us=0.0, missed_ticks=0)
            run_log.cycle(record, timing, state.rod, truth)
            plant.step(command)
            if tick % 100 == 0:
                gc.collect(0)
                while run_log.waiting > 1000:  # the recorder is slower than lockstep: nothing may be dropped here
                    time.sleep(0.001)
            if tick % max(1, cycles // 100) == 0:
                memory.append(resident())
    warm = memory[int(WARM * len(memory)) :]
    growth = max(warm) - warm[0]
    print(
        json.dumps(
            {
                "cycles": cycles,
                "seconds": round(time.monotonic() - started, 1),
                "resident_mb_after_warm_up": round(warm[0] / MEGABYTE, 2),
                "resident_mb_most": round(max(warm) / MEGABYTE, 2),
                "resident_mb_end": round(warm[-1] / MEGABYTE, 2),
                "growth_mb": round(growth / MEGABYTE, 2),
                "log": run_log.summary.replace(folder, "..."),
            }
        ),
        flush=True,
    )
    return growth <= FLAT and run_log.dropped == 0


def real_time(minutes: float) -> bool:
    """Track for so long, a bare loop beside it; then count what is in the log.

    A fault is written down, reset, and tracking goes on: a machine that stands still for a tenth of a second makes
    one by right, and the bare loop shows whether it did.
    """
    faults: list[str] = []
    with tempfile.TemporaryDirectory() as name, rig(Path(name), SPLIT + "[faults]\n") as one:
        controller, simulator = one.controller(), one.start("simulate")
        with suppress(PermissionError):  # whoever else is busy must not take the poses away
            os.setpriority(os.PRIO_PROCESS, simulator.pid, -15)
        with one.session() as session:
            one.arm(session)
            bare = subprocess.Popen(
                [sys.executable, "-m", "tendond.offline.bench.bare", "bare", str(60.0 * minutes), "0.01"],
                stdout=subprocess.PIPE,
                text=True,
            )
            end, before = time.monotonic() + 60.0 * minutes, Mode.TRACKING
            while (status := one.status(session)) and time.monotonic() < end:
                if status.mode is Mode.FAULT:
                    if before is not Mode.FAULT:
                        faults.append(status.reason)
                        print(f"soak: fault at tick {status.tick}: {status.reason}", file=sys.stderr, flush=True)
                    one.ask(session, ControlAction.RESET)
                elif status.mode is Mode.IDLE:
                    one.ask(session, ControlAction.ARM)
                before = status.mode
                time.sleep(0.5)
            bare_result = json.loads(bare.communicate()[0])
        one.end(simulator)
        code, said = one.end(controller)
        ticks = [record.tick for record in load(Path(name) / "run.mcap").records]  # and in the files that follow it
        files = len(list(Path(name).glob("run*.mcap")))
    stall, bare_missed = max(bare_result["late_us"]) / 1e6, bare_result["missed"]
    standstill = RigConfig().faults.overrun_time
    own = [reason for reason in faults if not (reason.startswith("overrun") and stall >= standstill)]
    wrong = {
        "the log lacks cycles": ticks != list(range(len(ticks))),
        "the log lacks entries": status.loop.log_dropped != 0,
        f"exit status {code}": code != 0,
        "it does not track at the end": status.mode is not Mode.TRACKING,
        f"{len(own)} faults that no standstill explains: {'; '.join(own)}": bool(own),
        "more deadlines missed than by the bare loop": status.loop.missed_ticks > bare_missed + ALONE * minutes,
    }
    print(
        json.dumps(
            {
                "minutes": minutes,
                "cycles": len(ticks),
                "files": files,
                "faults": faults,
                "deadlines_missed": status.loop.missed_ticks,
                "bare_loop_missed": bare_missed,
                "bare_loop_longest_stall_s": round(stall, 4),
                "rejected": status.rejected,
                "log_dropped": status.loop.log_dropped,
                "said": said.splitlines()[-1].replace(name, "..."),
            }
        )
    )
    failures = [what for what, holds in wrong.items() if holds]
    print("soak: FAILED: " + ", ".join(failures) if failures else "soak: passed", flush=True)
    return not failures


def main() -> None:
    """See the module."""
    if len(sys.argv) != 3 or sys.argv[1] not in ("cycles", "minutes"):
        raise SystemExit(__doc__)
    sound = lockstep(int(sys.argv[2])) if sys.argv[1] == "cycles" else real_time(float(sys.argv[2]))
    raise SystemExit(0 if sound else 1)


if __name__ == "__main__":
    main()
