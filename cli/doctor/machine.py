"""Checks of the computer: what a punctual loop needs."""

import os
import time
from pathlib import Path

from tendond.cli.doctor.check import CheckResult, Machine, Rig, failed, passed, warned
from tendond.daemon.runtime.realtime import CAP_IPC_LOCK

CAP_SYS_NICE = 23
FIFO = 1
PRECISE_CLOCKS = ("tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page", "xen")
IDLE_SHARE = 0.02
"""Fraction of the period that waking the processor may take."""

LATE_SHARE = 0.1
"""Fraction of the period by which a sleep may end late."""

NAPS, NAP_SECONDS = 100, 0.001
LIMITS_REMEDY = "run it as a service (deploy/install), or allow it in /etc/security/limits.d: @tendond - {} {}"


def priority(rig: Rig) -> CheckResult:
    """Check the controller's real-time priority, or whether this user may request it."""
    wanted = rig.config.loop.priority
    if not wanted:
        return passed("not requested (loop.priority = 0)")
    machine, pid = rig.machine, find_controller(rig)
    if pid is not None:
        fields = (machine.read(machine.proc / str(pid) / "stat") or "").rpartition(")")[2].split()
        policy, current = (int(fields[38]), int(fields[37])) if len(fields) > 38 else (0, 0)
        if policy == FIFO and current == wanted:
            return passed(f"the controller (process {pid}) has FIFO priority {wanted}")
        return warned(
            f"the controller (process {pid}) has no FIFO priority {wanted}", LIMITS_REMEDY.format("rtprio", wanted)
        )
    limit = _limit(machine, "Max realtime priority")
    if limit is None or limit >= wanted or _has_capability(machine, CAP_SYS_NICE):
        return passed(f"FIFO priority {wanted} may be requested here")
    return warned(
        f"FIFO priority {wanted} may not be requested here (limit {limit:g})", LIMITS_REMEDY.format("rtprio", wanted)
    )


def memory(rig: Rig) -> CheckResult:
    """Check that the controller's memory is locked, or may be."""
    if not rig.config.loop.lock_memory:
        return passed("lock not requested (loop.lock_memory = false)")
    machine, pid = rig.machine, find_controller(rig)
    remedy = LIMITS_REMEDY.format("memlock", "unlimited")
    if pid is not None:
        locked, resident = (int((_status(machine, str(pid), name).split() or "0")[0]) for name in ("VmLck", "VmRSS"))
        if locked >= resident > 0:
            return passed(f"the controller (process {pid}) has {locked / 1024:.0f} MiB locked")
        return warned(f"the controller (process {pid}) is not locked in memory", remedy)
    limit = _limit(machine, "Max locked memory")
    if limit is None or _has_capability(machine, CAP_IPC_LOCK):
        return passed("may be locked here")
    return warned(f"may not be locked here (limit {limit / 1024:.0f} KiB)", remedy)


def preemption(rig: Rig) -> CheckResult:
    """Check that the kernel can be preempted."""
    machine = rig.machine
    version = machine.read(machine.proc / "version") or ""
    if machine.read(machine.sys / "kernel" / "realtime") == "1" or "PREEMPT_RT" in version:
        return passed("a real-time kernel (PREEMPT_RT)")
    chosen = machine.read(machine.sys / "kernel" / "debug" / "sched" / "preempt") or ""
    line = machine.read(machine.proc / "cmdline") or ""
    if "(full)" in chosen or "preempt=full" in line.split() or ("PREEMPT" in version.split()):
        return passed("a preemptible kernel")
    if "PREEMPT_DYNAMIC" in version and not chosen and "preempt=" not in line:
        return warned(
            "the kernel can be preempted, but may not be configured to be (PREEMPT_DYNAMIC)",
            "boot with preempt=full, or install a real-time kernel (Debian: linux-image-rt-amd64)",
        )
    return warned(
        "the kernel is not preemptible: it may delay the loop by milliseconds",
        "boot with preempt=full, or install a real-time kernel (Debian: linux-image-rt-amd64)",
    )


def idle_states(rig: Rig) -> CheckResult:
    """Check the processor's exit latency from idle states."""
    machine = rig.machine
    states = sorted((machine.sys / "devices" / "system" / "cpu" / "cpu0" / "cpuidle").glob("state*"))
    enabled = [state for state in states if machine.read(state / "disable") != "1"]
    worst = max((int(machine.read(state / "latency") or 0) for state in enabled), default=0)
    if not enabled:
        return passed("the processor has no idle states, as in a virtual machine")
    if worst <= IDLE_SHARE * rig.config.loop.period * 1e6:
        return passed(f"the processor wakes up within {worst} us")
    return warned(
        f"the processor may take {worst} us to wake up, of a period of {rig.config.loop.period * 1e6:g} us",
        "tuned-adm profile latency-performance (it holds /dev/cpu_dma_latency), or boot with processor.max_cstate=1",
    )


def governor(rig: Rig) -> CheckResult:
    """Check that the processor keeps its frequency between cycles."""
    machine = rig.machine
    files = sorted((machine.sys / "devices" / "system" / "cpu").glob("cpu[0-9]*/cpufreq/scaling_governor"))
    if rig.config.loop.cpu is not None:
        files = [file for file in files if file.parts[-3] == f"cpu{rig.config.loop.cpu}"]
    found = sorted({machine.read(file) or "?" for file in files})
    if not found:
        return passed("the processor's frequency is not changed from here")
    if found == ["performance"]:
        return passed("the processor keeps its frequency (performance)")
    return warned(
        f"the processor's frequency is governed by {', '.join(found)}", "cpupower frequency-set -g performance"
    )


def processor(rig: Rig) -> CheckResult | None:
    """Check that the processor of loop.cpu is online."""
    wanted = rig.config.loop.cpu
    if wanted is None:
        return None
    online = rig.machine.read(rig.machine.sys / "devices" / "system" / "cpu" / "online") or "0"
    if wanted in _numbers(online):
        return passed(f"processor {wanted} is online (online: {online})")
    return failed(f"processor {wanted} is not online (online: {online})", "fix loop.cpu, or remove it")


def clock(rig: Rig) -> CheckResult:
    """Check the monotonic clock of the loop."""
    machine = rig.machine
    folder = machine.sys / "devices" / "system" / "clocksource" / "clocksource0"
    source = machine.read(folder / "current_clocksource") or "unknown"
    resolution = time.clock_getres(time.CLOCK_MONOTONIC)
    if resolution > 1e-6:
        return failed(f"{source}, in steps of {resolution * 1e6:g} us", "boot without nohz=off and highres=off")
    if source not in PRECISE_CLOCKS:
        return warned(f"{source}, which is slow to read", "boot with clocksource=tsc tsc=reliable")
    return passed(f"{source}, in steps of {resolution * 1e9:g} ns")


def wall_clock(rig: Rig) -> CheckResult:
    """Check the wall clock, which dates the logs; control does not use it."""
    if rig.machine.is_synchronised():
        return passed("synchronised")
    return warned(
        "not synchronised: timestamps will differ between computers", "systemctl enable --now systemd-timesyncd"
    )


def wake_up(rig: Rig) -> CheckResult:
    """Measure the wake-up delay of this process, which has no priority."""
    late = []
    for _ in range(NAPS):
        before = time.monotonic()
        time.sleep(NAP_SECONDS)
        late.append(time.monotonic() - before - NAP_SECONDS)
    late.sort()
    finding = f"median wake-up delay {late[NAPS // 2] * 1e6:.0f} us, maximum {late[-1] * 1e6:.0f} us"
    if late[-1] > LATE_SHARE * rig.config.loop.period:
        return warned(f"{finding}, without priority", "see the lines above, and other processes (top)")
    return passed(finding)


def find_controller(rig: Rig) -> int | None:
    """Find the process that runs this configuration, if any."""
    wanted = None if rig.config_file is None else rig.config_file.resolve()
    for folder in sorted(rig.machine.proc.glob("[0-9]*"), key=lambda path: int(path.name)):
        words = (rig.machine.read(folder / "cmdline") or "").split("\0")
        if not _runs_controller(words):
            continue
        named = [words[i + 1] for i, word in enumerate(words[:-1]) if word in {"--config", "-c"}]
        try:
            here = Path(os.readlink(folder / "cwd"))
        except OSError:
            here = Path("/")
        if (None if not named else (here / named[0]).resolve()) == wanted:
            return int(folder.name)
    return None


def _runs_controller(words: list[str]) -> bool:
    """Check that a process's arguments are those of `tendond run` or `tendond rig run`."""
    if "run" not in words:
        return False
    before = words[: words.index("run")]
    if before[-1:] == ["rig"]:
        before.pop()
    return bool(before) and Path(before[-1]).name.startswith("tendond")


def _limit(machine: Machine, name: str) -> float | None:
    """Read a soft limit of this process; none: unlimited."""
    for line in (machine.read(machine.proc / "self" / "limits") or "").splitlines():
        if line.startswith(name):
            value = line[len(name) :].split()[0]
            return None if value == "unlimited" else float(value)
    return 0.0


def _status(machine: Machine, process: str, name: str) -> str:
    for line in (machine.read(machine.proc / process / "status") or "").splitlines():
        if line.startswith(f"{name}:"):
            return line.partition(":")[2].strip()
    return ""


def _has_capability(machine: Machine, bit: int) -> bool:
    return bool(int(_status(machine, "self", "CapEff") or "0", 16) >> bit & 1)


def _numbers(ranges: str) -> set[int]:
    """Parse ranges such as '0-3,6'."""
    found: set[int] = set()
    for part in ranges.split(","):
        first, _, last = part.partition("-")
        found.update(range(int(first), int(last or first) + 1))
    return found
