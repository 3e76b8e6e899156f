"""Rules of the registers in EEPROM: identity, modes, limits, shutdown."""

import time

from tests.conformance import manual
from tests.conformance.bench import ServoBench
from tests.conformance.rules.table import rule


@rule("ID(7)")
def new_id(bench: ServoBench) -> bool:
    """A servo is heard under its new id from the next packet on, and after a reboot."""
    bench.put("ID", 77)
    old, new = bench.host.ask(1, manual.PING), bench.host.ask(77, manual.PING)
    bench.host.ask(77, manual.REBOOT)
    return not old and len(new) == 1 and len(bench.host.ask(77, manual.PING)) == 1


@rule("Baud Rate(8)")
def baud_rates(bench: ServoBench) -> bool:
    """Each of the eight codes is a rate, up to 4.5 Mbit/s, and the servo listens at it."""
    heard = []
    for code, rate in manual.BAUD_RATES.items():
        bench.put("Baud Rate", code)
        bench.host.set_rate(rate)
        heard.append(len(bench.host.ask(1, manual.PING)))
    bench.host.set_rate(57600)
    return heard == [1] * len(manual.BAUD_RATES) and not bench.host.ask(1, manual.PING)


@rule("Return Delay Time(9)")
def return_delay(bench: ServoBench) -> bool:
    """Replies come no sooner than the delay, in units of 2 us."""
    bench.put("Return Delay Time", 254)
    return min(bench.host.ask(1, manual.PING)[0].after for _ in range(5)) >= 508e-6


@rule("Drive Mode(10)")
def reverse(bench: ServoBench) -> bool:
    """Reverse mode inverts Present Position and Goal Position."""
    bench.put("Operating Mode", 4)
    bench.put("Drive Mode", 1)
    bench.until(lambda: bench.get("Present Position", signed=True) == -1000)
    before = bench.first.position
    bench.put("Torque Enable", 1)
    bench.put("Goal Position", -900)
    bench.until(lambda: abs(bench.get("Present Position", signed=True) + 900) < 3)
    return bench.first.position < before - 90


@rule("Drive Mode(10)")
def torque_by_goal(bench: ServoBench) -> bool:
    """Torque On by Goal Update lets a goal switch the torque on."""
    bench.put("Operating Mode", 4)
    bench.put("Drive Mode", 8)
    bench.put("Goal Position", 1010)
    return bench.get("Torque Enable") == 1


@rule("Drive Mode(10)")
def time_based(bench: ServoBench) -> bool:
    """Profile Velocity of a time-based profile is the time that the motion takes [ms]."""
    bench.put("Drive Mode", 4)
    bench.extended()
    bench.put("Profile Velocity", 600)
    began = time.monotonic()
    bench.put("Goal Position", 1400)
    bench.until(lambda: abs(bench.get("Present Position", signed=True) - 1400) < 5)
    return 0.5 < time.monotonic() - began < 1.5


@rule("Operating Mode(11)")
def modes(bench: ServoBench) -> bool:
    """Modes 1, 3, 4 and 16 exist, no others."""
    there = all(bench.put("Operating Mode", mode) == 0 for mode in manual.OPERATING_MODES)
    return there and all(bench.put("Operating Mode", mode) == manual.RANGE_ERROR for mode in manual.NO_MODES)


@rule("Operating Mode(11)")
def mode_resets(bench: ServoBench) -> bool:
    """A change of mode clears the profiles and sets Goal PWM to the PWM Limit and the gains to their initial values."""
    for name, value in (("Profile Velocity", 9), ("Profile Acceleration", 9), ("Goal PWM", 9), ("Position P Gain", 9)):
        bench.put(name, value)
    bench.put("Operating Mode", 4)
    found = [bench.get(name) for name in ("Profile Velocity", "Profile Acceleration", "Goal PWM", "Position P Gain")]
    return found == [0, 0, 885, 640]


@rule("Operating Mode(11)")
def velocity_mode(bench: ServoBench) -> bool:
    """Goal Velocity is the speed of the shaft in velocity control."""
    bench.put("Operating Mode", 1)
    bench.put("Torque Enable", 1)
    bench.put("Goal Velocity", 100)
    steady = bench.until(lambda: abs(bench.get("Present Velocity", signed=True) - 100) < 3)
    bench.put("Goal Velocity", 0)
    return steady and bench.until(lambda: bench.get("Moving") == 0)


@rule("Operating Mode(11)")
def pwm_mode(bench: ServoBench) -> bool:
    """Goal PWM gives the direction of the shaft in PWM control."""
    bench.put("Operating Mode", 16)
    bench.put("Torque Enable", 1)
    bench.put("Goal PWM", -200)
    return bench.until(lambda: bench.get("Present Velocity", signed=True) < -20)


@rule("Secondary(Shadow) ID(12)")
def secondary_id(bench: ServoBench) -> bool:
    """Instructions to a Secondary ID are carried out without a reply, in RAM alone; a primary id comes first."""
    bench.put("Secondary(Shadow) ID", 50)
    silent = not bench.whisper("LED", 1, 50)
    bench.whisper("Return Delay Time", 7, 50)
    bench.put("Secondary(Shadow) ID", 2, 1)
    replies = bench.whisper("LED", 0, 2)
    return (
        silent and bench.get("Return Delay Time") == 250 and [one.id for one in replies] == [2] and not bench.get("LED")
    )


@rule("Homing Offset(20)")
def homing_offset(bench: ServoBench) -> bool:
    """Present Position is the actual position plus the offset, and a goal includes it as well."""
    bench.put("Homing Offset", 300)
    bench.until(lambda: bench.get("Present Position", signed=True) == 1300)
    bench.extended()
    bench.put("Goal Position", 1350)
    return bench.until(lambda: abs(bench.first.position - 1050.0) < 3.0)


@rule("Temperature Limit(31), Shutdown(63)")
def overheating(bench: ServoBench) -> bool:
    """Temperatures beyond the limit are an Overheating Error; the torque goes off where Shutdown has its bit."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "temperature", 73.0))
    return bench.until(lambda: bench.get("Hardware Error Status") == 0b100) and bench.get("Torque Enable") == 0


@rule("Min/Max Voltage Limit(32, 34), Shutdown(63)")
def input_voltage(bench: ServoBench) -> bool:
    """Voltages beyond the limits are an Input Voltage Error, which by default leaves the torque on."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "voltage", 14.5))
    return bench.until(lambda: bench.get("Hardware Error Status") == 0b1) and bench.get("Torque Enable") == 1


@rule("Shutdown(63)")
def overload(bench: ServoBench) -> bool:
    """Loads that last beyond what it can hold are an Overload Error; only a reboot brings the torque back."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: 3.0))
    off = bench.until(lambda: bench.get("Hardware Error Status") == 0b100000 and bench.get("Torque Enable") == 0)
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: 0.0))
    refused = bench.put("Torque Enable", 1)
    bench.host.ask(1, manual.REBOOT)
    return off and refused == manual.RESULT_FAIL and bench.put("Torque Enable", 1) == 0


@rule("Shutdown(63)")
def shutdown_bits(bench: ServoBench) -> bool:
    """Bits 1, 6 and 7 do not exist."""
    there = all(bench.put("Shutdown", 1 << bit) == 0 for bit in manual.SHUTDOWN_BITS)
    return there and all(bench.put("Shutdown", 1 << bit) == manual.RANGE_ERROR for bit in (1, 6, 7))


@rule("PWM Limit(36), Goal PWM(100)")
def pwm_limit(bench: ServoBench) -> bool:
    """Goal PWM cannot exceed the PWM Limit, and starts there."""
    bench.put("PWM Limit", 300)
    bench.host.ask(1, manual.REBOOT)
    return (
        bench.get("Goal PWM") == 300
        and bench.put("Goal PWM", 301) == manual.LIMIT_ERROR
        and not bench.put("Goal PWM", -300)
    )


@rule("PWM Limit(36), Goal PWM(100)")
def goal_pwm_holds_less(bench: ServoBench) -> bool:
    """Goal PWM limits the output in position control: at a tenth a servo cannot hold a quarter of its torque."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: -0.35))
    time.sleep(0.1)
    holds = abs(bench.get("Present Position", signed=True) - 1000) < 5
    bench.put("Goal PWM", 88)
    return holds and bench.until(lambda: bench.get("Present Position", signed=True) < 990)


@rule("Velocity Limit(44), Goal Velocity(104)")
def velocity_limit(bench: ServoBench) -> bool:
    """Goal Velocity cannot exceed the Velocity Limit."""
    bench.put("Velocity Limit", 50)
    return bench.put("Goal Velocity", 51) == manual.LIMIT_ERROR and bench.put("Goal Velocity", -50) == 0


@rule("Min/Max Position Limit(48, 52)")
def position_limits(bench: ServoBench) -> bool:
    """Goals of Position Control are bounded by the limits, those of extended position control by 256 turns."""
    bench.put("Max Position Limit", 2000)
    one_turn = bench.put("Goal Position", 2001)
    bench.put("Operating Mode", 4)
    many, beyond = bench.put("Goal Position", -1_048_575), bench.put("Goal Position", 1_048_576)
    return (one_turn, many, beyond) == (manual.LIMIT_ERROR, 0, manual.RANGE_ERROR)


@rule("Startup Configuration(60)")
def startup_torque(bench: ServoBench) -> bool:
    """Startup Torque On leaves the torque on after a reboot."""
    bench.put("Startup Configuration", 1)
    bench.host.ask(1, manual.REBOOT)
    return bench.get("Torque Enable") == 1
