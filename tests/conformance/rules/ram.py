"""Rules of the registers in RAM: status, watchdog, goals, profiles, readings."""

import time

from tests.conformance import manual
from tests.conformance.bench import ROWS, ServoBench
from tests.conformance.rules.table import rule, two


@rule("Status Return Level(68)")
def return_level_0(bench: ServoBench) -> bool:
    """Level 0 has replies to pings alone; everything is carried out all the same."""
    bench.put("Status Return Level", 0)
    silent = not bench.whisper("LED", 1) and not bench.host.ask(1, manual.READ, two(65, 1))
    pinged = len(bench.host.ask(1, manual.PING)) == 1
    bench.whisper("Status Return Level", 2)
    return silent and pinged and bench.get("LED") == 1


@rule("Status Return Level(68)")
def return_level_1(bench: ServoBench) -> bool:
    """Level 1 has replies to pings and reads."""
    bench.put("Status Return Level", 1)
    return not bench.whisper("LED", 1) and bench.get("LED") == 1


@rule("Bus Watchdog(98)")
def watchdog(bench: ServoBench) -> bool:
    """The Bus Watchdog stops a servo with torque and no packets, shows -1, clears profiles, refuses goals until 0."""
    bench.extended()
    bench.put("Profile Velocity", 20)
    bench.put("Profile Acceleration", 10)
    bench.put("Goal Position", 50_000)
    bench.put("Bus Watchdog", 5)
    time.sleep(0.3)
    tripped = bench.get("Bus Watchdog", signed=True) == -1
    stopped = abs(bench.get("Present Position", signed=True) - bench.get("Present Position", signed=True)) < 2
    cleared = (bench.get("Profile Velocity"), bench.get("Profile Acceleration")) == (0, 0)
    refused = {bench.put(name, 1) for name in ("Goal Position", "Goal Velocity", "Goal PWM")}
    held = bench.get("Torque Enable") == 1
    bench.put("Bus Watchdog", 0)
    return (
        tripped
        and stopped
        and cleared
        and held
        and refused == {manual.RANGE_ERROR}
        and not bench.put("Goal Position", 1010)
    )


@rule("Bus Watchdog(98)")
def watchdog_without_torque(bench: ServoBench) -> bool:
    """The Bus Watchdog is idle without torque."""
    bench.put("Bus Watchdog", 2)
    time.sleep(0.2)
    return bench.get("Bus Watchdog", signed=True) == 2


@rule("Profile Velocity(112), Profile Acceleration(108)")
def profile(bench: ServoBench) -> bool:
    """A velocity-based profile is no faster than Profile Velocity."""
    bench.extended()
    bench.put("Profile Velocity", 50)
    bench.put("Goal Position", 5000)
    bench.until(lambda: bench.get("Moving") == 1)
    fastest = max(bench.get("Present Velocity", signed=True) for _ in range(40))
    return 45 <= fastest <= 51


@rule("Goal Position(116), Present Position(132)")
def turns(bench: ServoBench) -> bool:
    """Whole turns are counted beyond one, kept when the torque is switched, and lost in a reboot."""
    bench.extended()
    bench.put("Goal Position", 1000 + 4096)
    there = bench.until(lambda: abs(bench.get("Present Position", signed=True) - 5096) < 3)
    bench.put("Torque Enable", 0)
    bench.put("Torque Enable", 1)
    kept = abs(bench.get("Present Position", signed=True) - 5096) < 3
    bench.host.ask(1, manual.REBOOT)
    return there and kept and abs(bench.get("Present Position", signed=True) - 1000) < 3


@rule("Realtime Tick(120)")
def realtime_tick(bench: ServoBench) -> bool:
    """Realtime Tick counts milliseconds."""
    first, began = bench.get("Realtime Tick"), time.monotonic()
    time.sleep(0.2)
    passed = (bench.get("Realtime Tick") - first) % 32768
    return 0.5 < passed / (1e3 * (time.monotonic() - began)) < 1.5


@rule("Moving(122), Moving Status(123)")
def moving(bench: ServoBench) -> bool:
    """Both show a motion and its end, In-Position after its arrival."""
    bench.extended()
    bench.put("Profile Velocity", 60)
    bench.put("Goal Position", 1600)
    begun = bench.until(lambda: bench.get("Moving") == 1 and bench.get("Moving Status") & 2 != 0)
    ended = bench.until(lambda: bench.get("Moving") == 0 and bench.get("Moving Status") & 3 == 1)
    return begun and ended


@rule("Present Load(126)")
def present_load(bench: ServoBench) -> bool:
    """The load is that of the torque held, positive where it is held towards larger positions."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: -0.7))
    return bench.until(lambda: abs(bench.get("Present Load", signed=True) - 500) < 30)


@rule("Indirect Address, Indirect Data")
def indirect(bench: ServoBench) -> bool:
    """Indirect Data stands for the registers whose addresses are mapped, for reading and for writing."""
    for n in range(4):
        bench.put(f"Indirect Address {n + 2}", 116 + n)
    bench.put("Indirect Address 1", 65)
    bench.put("Indirect Data 1", 1)
    bench.put("Operating Mode", 4)
    error = bench.host.write(1, ROWS["Indirect Data 2"].address, 4, 1024)
    return bench.get("LED") == 1 and not error and bench.get("Goal Position") == 1024
