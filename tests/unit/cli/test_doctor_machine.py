"""The doctor's checks of the computer: rights, kernel, processor, clock, serial adapter."""

import pytest

from tendond.cli.doctor import machine, servos
from tendond.cli.doctor.check import CheckOutcome
from tests.unit.cli.computer import Computer

LIMITS = "Limit                     Soft Limit           Hard Limit           Units\n"


def test_rights_of_this_user(computer: Computer) -> None:
    computer.write("proc/self/status", "CapEff:\t0000000000000000\n")
    for limit, locked, expected in (
        ("0", "8388608", CheckOutcome.WARN),
        ("49", "8388608", CheckOutcome.WARN),
        ("50", "unlimited", CheckOutcome.PASS),
        ("unlimited", "unlimited", CheckOutcome.PASS),
    ):
        lines = f"Max realtime priority     {limit}   {limit}\nMax locked memory         {locked}   {locked}   bytes\n"
        computer.write("proc/self/limits", LIMITS + lines)
        assert computer.outcome(machine.priority) is expected
        assert computer.outcome(machine.memory) is expected
    computer.write(
        "proc/self/limits", LIMITS + "Max realtime priority     0  0\nMax locked memory         0  0  bytes\n"
    )
    computer.write("proc/self/status", f"CapEff:\t{1 << 23 | 1 << 14:016x}\n")
    assert computer.outcome(machine.priority) is CheckOutcome.PASS
    assert computer.outcome(machine.memory) is CheckOutcome.PASS


def test_a_running_controller_is_judged_by_what_it_has(computer: Computer) -> None:
    """Whatever the user's own rights are; another rig's controller does not count."""
    computer.write("proc/self/limits", LIMITS + "Max realtime priority     99  99\n")
    for pid, config, policy, locked in ((70, "other.toml", 1, 400000), (71, "rig.toml", 0, 12)):
        words = ["/opt/tendond/bin/python", "-m", "tendond.cli", "run", "--config", config]
        computer.write(f"proc/{pid}/cmdline", "\0".join(words) + "\0")
        computer.write(f"proc/{pid}/status", f"VmLck:\t{locked} kB\nVmRSS:\t300000 kB\n")
        fields = ["0"] * 50
        fields[37], fields[38] = str(50 * policy), str(policy)
        computer.write(f"proc/{pid}/stat", f"{pid} (a name) with ) in it) {' '.join(fields)}")
        (computer.folder / f"proc/{pid}/cwd").symlink_to(computer.folder)
    assert machine.find_controller(computer.rig) == 71
    assert computer.outcome(machine.priority) is CheckOutcome.WARN
    assert computer.outcome(machine.memory) is CheckOutcome.WARN
    computer.config_file = computer.folder / "other.toml"
    assert machine.find_controller(computer.rig) == 70
    assert computer.outcome(machine.priority) is CheckOutcome.PASS
    assert computer.outcome(machine.memory) is CheckOutcome.PASS
    computer.config_file = None
    assert machine.find_controller(computer.rig) is None


@pytest.mark.parametrize(
    ("version", "cmdline", "expected"),
    [
        ("Linux version 6.1.0-rt (#1 SMP PREEMPT_RT Debian)", "", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT_DYNAMIC Debian", "quiet preempt=full", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT_DYNAMIC Debian", "quiet", CheckOutcome.WARN),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT Debian", "", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP Debian", "", CheckOutcome.WARN),
    ],
)
def test_kernels_and_how_they_preempt(computer: Computer, version: str, cmdline: str, expected: CheckOutcome) -> None:
    computer.write("proc/version", version)
    computer.write("proc/cmdline", cmdline)
    assert computer.outcome(machine.preemption) is expected


def test_processor_clock_and_governor(computer: Computer) -> None:
    assert computer.outcome(machine.idle_states) is CheckOutcome.PASS  # none at all
    assert computer.outcome(machine.governor) is CheckOutcome.PASS
    cpu = "sys/devices/system/cpu"
    computer.write(f"{cpu}/cpu0/cpuidle/state1/latency", "2")
    computer.write(f"{cpu}/cpu0/cpuidle/state2/latency", "890")
    assert computer.outcome(machine.idle_states) is CheckOutcome.WARN
    computer.write(f"{cpu}/cpu0/cpuidle/state2/disable", "1")
    assert computer.outcome(machine.idle_states) is CheckOutcome.PASS
    computer.write(f"{cpu}/cpu0/cpufreq/scaling_governor", "performance\n")
    assert computer.outcome(machine.governor) is CheckOutcome.PASS
    computer.write(f"{cpu}/cpu1/cpufreq/scaling_governor", "powersave\n")
    assert computer.outcome(machine.governor) is CheckOutcome.WARN
    computer.write(f"{cpu}/online", "0-1,3\n")
    assert computer.outcome(machine.processor) is None
    for number, expected in ((0, CheckOutcome.PASS), (2, CheckOutcome.FAIL), (3, CheckOutcome.PASS)):
        computer.sections = {"loop": {"cpu": number}}
        assert computer.outcome(machine.processor) is expected
    assert computer.outcome(machine.governor) is CheckOutcome.PASS  # of processor 3 alone, which has none
    source = "sys/devices/system/clocksource/clocksource0/current_clocksource"
    for name, expected in (("tsc", CheckOutcome.PASS), ("hpet", CheckOutcome.WARN)):
        computer.write(source, name)
        assert computer.outcome(machine.clock) is expected
    assert computer.outcome(machine.wall_clock) is CheckOutcome.PASS
    computer.synchronised = False
    assert computer.outcome(machine.wall_clock) is CheckOutcome.WARN


def test_the_adapters_timer(computer: Computer) -> None:
    adapter = computer.folder / "ttyUSB7"
    computer.sections = {"limits": {"displacement_rate": 0.08, "displacement_min": -0.08, "displacement_max": 0.08}}
    computer.sections["servo"] = {"port": str(adapter)}
    assert computer.outcome(servos.port) is CheckOutcome.FAIL
    assert computer.outcome(servos.latency) is None
    adapter.touch()
    assert computer.outcome(servos.port) is CheckOutcome.FAIL  # a file, no port
    assert computer.outcome(servos.latency) is CheckOutcome.PASS  # no timer
    for milliseconds, expected in (("1", CheckOutcome.PASS), ("2", CheckOutcome.WARN), ("16", CheckOutcome.FAIL)):
        computer.write("sys/bus/usb-serial/devices/ttyUSB7/latency_timer", f"{milliseconds}\n")
        assert computer.outcome(servos.latency) is expected
