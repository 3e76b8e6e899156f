"""What the manual says in words: each function is one rule, named by its docstring, and true where it holds."""

import struct
import time
from collections.abc import Callable

from tests.conformance import manual
from tests.conformance.bench import ROWS, Bench
from tests.conformance.host import crc, packet, write_parameters

Rule = Callable[[Bench], bool]
RULES: list[tuple[str, Rule]] = []
"""Section of the manual, and rule."""


def rule(section: str) -> Callable[[Rule], Rule]:
    """Enter a rule under a section of the manual."""

    def enter(function: Rule) -> Rule:
        RULES.append((section, function))
        return function

    return enter


def _two(address: int, size: int) -> bytes:
    return struct.pack("<HH", address, size)


@rule("Protocol 2.0: packets")
def examples(bench: Bench) -> bool:
    """The packets that the manual prints have the CRC that it prints."""
    wires = [bytes.fromhex(text) for _, text in manual.EXAMPLES]
    return all(crc(wire[:-2]) == int.from_bytes(wire[-2:], "little") for wire in wires) and packet(1, 1) == wires[0]


@rule("Protocol 2.0: packets")
def stuffing(bench: Bench) -> bool:
    """FF FF FD within parameters is stuffed on its way in and out."""
    bench.put("Operating Mode", 4)
    headed = int.from_bytes(b"\xff\xff\xfd\xff", "little", signed=True)
    return bench.put("Goal Position", headed) == 0 and bench.get("Goal Position", signed=True) == headed


@rule("Protocol 2.0: error")
def wrong_crc(bench: Bench) -> bool:
    """A packet with a wrong CRC is answered by CRC Error, and does nothing."""
    broken = bytearray(packet(1, manual.WRITE, write_parameters(65, 1, 1)))
    broken[-1] ^= 0xFF
    (answer,) = bench.host.send(bytes(broken))
    return answer.error == manual.CRC_ERROR and bench.get("LED") == 0


@rule("Protocol 2.0: error")
def undefined_instruction(bench: Bench) -> bool:
    """An instruction that is none is answered by Instruction Error."""
    (answer,) = bench.host.ask(1, 0x77)
    return answer.error == manual.INSTRUCTION_ERROR


@rule("Protocol 2.0: error")
def alert(bench: Bench) -> bool:
    """A hardware error sets the alert bit of every answer, beside its error."""
    before = bench.host.ask(1, manual.PING)[0].alert
    bench.bus.apply(lambda: bench.first.fail(5))
    refused = bench.host.ask(1, manual.WRITE, write_parameters(69, 1, 0))[0]
    return not before and refused.alert and refused.error == manual.ACCESS_ERROR


@rule("Protocol 2.0: Ping")
def ping(bench: Bench) -> bool:
    """A ping is answered by model number and firmware, an id that is not there by nothing."""
    (answer,) = bench.host.ask(1, manual.PING)
    return answer.data[:2] == (1060).to_bytes(2, "little") and len(answer.data) == 3 and not bench.host.ask(9, 1)


@rule("Protocol 2.0: Ping")
def ping_all(bench: Bench) -> bool:
    """A ping to all is answered by each, in the order of the ids, whatever their Status Return Level."""
    bench.put("Status Return Level", 0, 2)
    return [answer.id for answer in bench.host.ask(manual.BROADCAST, manual.PING)] == [1, 2]


@rule("Protocol 2.0: Packet ID")
def broadcast_write(bench: Bench) -> bool:
    """A write to all is done by each and answered by none; a read of all is not answered."""
    silent = not bench.host.ask(manual.BROADCAST, manual.WRITE, write_parameters(65, 1, 1))
    unread = not bench.host.ask(manual.BROADCAST, manual.READ, _two(65, 1))
    return silent and unread and (bench.get("LED", 1), bench.get("LED", 2)) == (1, 1)


@rule("Protocol 2.0: Read")
def long_read(bench: Bench) -> bool:
    """A read from a register on may span others and gaps, and not the table's end."""
    whole = bench.host.read(1, 64, 83)
    beyond = bench.host.read(1, 661, 2)
    return whole.error == 0 and len(whole.data) == 83 and beyond.error == manual.ACCESS_ERROR


@rule("Protocol 2.0: Write")
def long_write(bench: Bench) -> bool:
    """A write may span registers that follow each other."""
    (answer,) = bench.host.ask(1, manual.WRITE, struct.pack("<HII", 108, 7, 8))
    return answer.error == 0 and (bench.get("Profile Acceleration"), bench.get("Profile Velocity")) == (7, 8)


@rule("Protocol 2.0: Reg Write, Action")
def reg_write(bench: Bench) -> bool:
    """A registered write waits for the action, and Registered Instruction shows it."""
    (kept,) = bench.host.ask(1, manual.REG_WRITE, write_parameters(65, 1, 1))
    waiting = bench.get("LED") == 0 and bench.get("Registered Instruction") == 1
    (done,) = bench.host.ask(1, manual.ACTION)
    return (
        not kept.error
        and waiting
        and not done.error
        and bench.get("LED") == 1
        and not bench.get("Registered Instruction")
    )


@rule("Protocol 2.0: Reg Write, Action")
def action_for_all(bench: Bench) -> bool:
    """An action for all carries out what each has registered, at once."""
    for one in (1, 2):
        bench.host.ask(one, manual.REG_WRITE, write_parameters(65, 1, 1))
    silent = not bench.host.ask(manual.BROADCAST, manual.ACTION)
    return silent and (bench.get("LED", 1), bench.get("LED", 2)) == (1, 1)


@rule("Protocol 2.0: Reg Write, Action")
def empty_action(bench: Bench) -> bool:
    """An action without a registered write is an Instruction Error."""
    return bench.host.ask(1, manual.ACTION)[0].error == manual.INSTRUCTION_ERROR


@rule("Protocol 2.0: Factory Reset")
def factory_reset(bench: Bench) -> bool:
    """Option 1 keeps the id, option 2 id and rate; the rest is as in the factory."""
    bench.put("Return Delay Time", 5, 2)
    bench.put("Shutdown", 0, 2)
    (answer,) = bench.host.ask(2, manual.FACTORY_RESET, b"\x02")
    return not answer.error and (bench.get("Return Delay Time", 2), bench.get("Shutdown", 2)) == (250, 52)


@rule("Protocol 2.0: Factory Reset")
def factory_reset_of_all(bench: Bench) -> bool:
    """Reset of everything is not for all at once."""
    bench.put("Return Delay Time", 5)
    bench.host.ask(manual.BROADCAST, manual.FACTORY_RESET, b"\xff")
    return bench.get("Return Delay Time") == 5 and bench.get("ID", 2) == 2


@rule("Protocol 2.0: Reboot")
def reboot(bench: Bench) -> bool:
    """A reboot is answered; RAM has its initial values, EEPROM is kept, the torque is off."""
    bench.put("Return Delay Time", 5)
    bench.extended()
    bench.put("LED", 1)
    (answer,) = bench.host.ask(1, manual.REBOOT)
    kept = (bench.get("Return Delay Time"), bench.get("Operating Mode")) == (5, 4)
    return not answer.error and kept and (bench.get("LED"), bench.get("Torque Enable")) == (0, 0)


@rule("Protocol 2.0: Clear")
def clear(bench: Bench) -> bool:
    """Clear takes the whole turns off Present Position, of a servo that stands still."""
    bench.put("Operating Mode", 4)
    bench.bus.apply(lambda: bench.first._shaft.place(1000.0 + 3 * 4096))
    bench.until(lambda: bench.get("Present Position", signed=True) == 1000 + 3 * 4096)
    (answer,) = bench.host.ask(1, manual.CLEAR, manual.CLEAR_TURNS)
    return not answer.error and bench.get("Present Position", signed=True) == 1000


@rule("Protocol 2.0: Clear")
def clear_in_motion(bench: Bench) -> bool:
    """Clear of a servo that moves is a Result Fail."""
    bench.extended()
    bench.put("Profile Velocity", 20)
    bench.put("Goal Position", 100_000)
    moving = bench.until(lambda: bench.get("Moving") == 1)
    (answer,) = bench.host.ask(1, manual.CLEAR, manual.CLEAR_TURNS)
    return moving and answer.error == manual.RESULT_FAIL


@rule("Protocol 2.0: Sync Read, Sync Write")
def sync(bench: Bench) -> bool:
    """One packet writes, one reads the same registers of several servos, each with an answer of its own."""
    bench.host.ask(manual.BROADCAST, manual.SYNC_WRITE, _two(112, 4) + b"\x01\x10\0\0\0\x02\x20\0\0\0")
    answers = bench.host.ask(manual.BROADCAST, manual.SYNC_READ, _two(112, 4) + b"\x01\x02")
    return [(one.id, int.from_bytes(one.data, "little")) for one in answers] == [(1, 16), (2, 32)]


@rule("Protocol 2.0: Bulk Read, Bulk Write")
def bulk(bench: Bench) -> bool:
    """One packet writes, one reads different registers of several servos."""
    items = b"\x01" + _two(32, 2) + b"\x78\x00" + b"\x02" + _two(31, 1) + b"\x50"
    bench.host.ask(manual.BROADCAST, manual.BULK_WRITE, items)
    answers = bench.host.ask(manual.BROADCAST, manual.BULK_READ, b"\x01" + _two(32, 2) + b"\x02" + _two(31, 1))
    return [(one.id, int.from_bytes(one.data, "little")) for one in answers] == [(1, 120), (2, 80)]


@rule("Protocol 2.0: Fast Sync Read")
def fast_sync(bench: Bench) -> bool:
    """All answer in one packet: error, id, data and CRC of each."""
    (answer,) = bench.host.ask(manual.BROADCAST, manual.FAST_SYNC_READ, _two(7, 1) + b"\x01\x02")
    # the first error stands apart; id, data, CRC of the first, error, id, data of the second, whose CRC is the packet's
    return answer.id == manual.BROADCAST and answer.data[:2] == b"\x01\x01" and answer.data[4:7] == b"\x00\x02\x02"


@rule("ID(7)")
def new_id(bench: Bench) -> bool:
    """A servo is heard under its new id from the next packet on, and after a reboot."""
    bench.put("ID", 77)
    old, new = bench.host.ask(1, manual.PING), bench.host.ask(77, manual.PING)
    bench.host.ask(77, manual.REBOOT)
    return not old and len(new) == 1 and len(bench.host.ask(77, manual.PING)) == 1


@rule("Baud Rate(8)")
def baud_rates(bench: Bench) -> bool:
    """Each of the eight codes is a rate, up to 4.5 Mbit/s, and the servo listens at it."""
    heard = []
    for code, rate in manual.BAUD_RATES.items():
        bench.put("Baud Rate", code)
        bench.host.set_rate(rate)
        heard.append(len(bench.host.ask(1, manual.PING)))
    bench.host.set_rate(57600)
    return heard == [1] * len(manual.BAUD_RATES) and not bench.host.ask(1, manual.PING)


@rule("Return Delay Time(9)")
def return_delay(bench: Bench) -> bool:
    """An answer comes no sooner than the delay, in units of 2 us."""
    bench.put("Return Delay Time", 254)
    return min(bench.host.ask(1, manual.PING)[0].after for _ in range(5)) >= 508e-6


@rule("Drive Mode(10)")
def reverse(bench: Bench) -> bool:
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
def torque_by_goal(bench: Bench) -> bool:
    """With Torque On by Goal Update a goal switches the torque on."""
    bench.put("Operating Mode", 4)
    bench.put("Drive Mode", 8)
    bench.put("Goal Position", 1010)
    return bench.get("Torque Enable") == 1


@rule("Drive Mode(10)")
def time_based(bench: Bench) -> bool:
    """With a time-based profile Profile Velocity is the time that the motion takes [ms]."""
    bench.put("Drive Mode", 4)
    bench.extended()
    bench.put("Profile Velocity", 600)
    began = time.monotonic()
    bench.put("Goal Position", 1400)
    bench.until(lambda: abs(bench.get("Present Position", signed=True) - 1400) < 5)
    return 0.5 < time.monotonic() - began < 1.5


@rule("Operating Mode(11)")
def modes(bench: Bench) -> bool:
    """Modes 1, 3, 4 and 16 are there, no others."""
    there = all(bench.put("Operating Mode", mode) == 0 for mode in manual.OPERATING_MODES)
    return there and all(bench.put("Operating Mode", mode) == manual.RANGE_ERROR for mode in manual.NO_MODES)


@rule("Operating Mode(11)")
def mode_resets(bench: Bench) -> bool:
    """A change of mode clears the profiles and sets Goal PWM to the PWM Limit and the gains to their initial values."""
    for name, value in (("Profile Velocity", 9), ("Profile Acceleration", 9), ("Goal PWM", 9), ("Position P Gain", 9)):
        bench.put(name, value)
    bench.put("Operating Mode", 4)
    found = [bench.get(name) for name in ("Profile Velocity", "Profile Acceleration", "Goal PWM", "Position P Gain")]
    return found == [0, 0, 885, 640]


@rule("Operating Mode(11)")
def velocity_mode(bench: Bench) -> bool:
    """In velocity control the shaft turns at Goal Velocity."""
    bench.put("Operating Mode", 1)
    bench.put("Torque Enable", 1)
    bench.put("Goal Velocity", 100)
    steady = bench.until(lambda: abs(bench.get("Present Velocity", signed=True) - 100) < 3)
    bench.put("Goal Velocity", 0)
    return steady and bench.until(lambda: bench.get("Moving") == 0)


@rule("Operating Mode(11)")
def pwm_mode(bench: Bench) -> bool:
    """In PWM control the shaft turns the way of Goal PWM."""
    bench.put("Operating Mode", 16)
    bench.put("Torque Enable", 1)
    bench.put("Goal PWM", -200)
    return bench.until(lambda: bench.get("Present Velocity", signed=True) < -20)


@rule("Secondary(Shadow) ID(12)")
def secondary_id(bench: Bench) -> bool:
    """What is told to a Secondary ID is done and not answered, in RAM alone; a primary id comes first."""
    bench.put("Secondary(Shadow) ID", 50)
    silent = not bench.whisper("LED", 1, 50)
    bench.whisper("Return Delay Time", 7, 50)
    bench.put("Secondary(Shadow) ID", 2, 1)
    answers = bench.whisper("LED", 0, 2)
    return (
        silent and bench.get("Return Delay Time") == 250 and [one.id for one in answers] == [2] and not bench.get("LED")
    )


@rule("Homing Offset(20)")
def homing_offset(bench: Bench) -> bool:
    """Present Position is the actual position and the offset, which a goal has in it as well."""
    bench.put("Homing Offset", 300)
    bench.until(lambda: bench.get("Present Position", signed=True) == 1300)
    bench.extended()
    bench.put("Goal Position", 1350)
    return bench.until(lambda: abs(bench.first.position - 1050.0) < 3.0)


@rule("Temperature Limit(31), Shutdown(63)")
def overheating(bench: Bench) -> bool:
    """Beyond the limit there is an Overheating Error, and the torque goes off where Shutdown says so."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "temperature", 73.0))
    return bench.until(lambda: bench.get("Hardware Error Status") == 0b100) and bench.get("Torque Enable") == 0


@rule("Min/Max Voltage Limit(32, 34), Shutdown(63)")
def input_voltage(bench: Bench) -> bool:
    """Beyond the limits there is an Input Voltage Error, which by default leaves the torque on."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "voltage", 14.5))
    return bench.until(lambda: bench.get("Hardware Error Status") == 0b1) and bench.get("Torque Enable") == 1


@rule("Shutdown(63)")
def overload(bench: Bench) -> bool:
    """A load that lasts beyond what it can hold is an Overload Error; the torque comes back after a reboot alone."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: 3.0))
    off = bench.until(lambda: bench.get("Hardware Error Status") == 0b100000 and bench.get("Torque Enable") == 0)
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: 0.0))
    refused = bench.put("Torque Enable", 1)
    bench.host.ask(1, manual.REBOOT)
    return off and refused == manual.RESULT_FAIL and bench.put("Torque Enable", 1) == 0


@rule("Shutdown(63)")
def shutdown_bits(bench: Bench) -> bool:
    """Bits 1, 6 and 7 do not exist."""
    there = all(bench.put("Shutdown", 1 << bit) == 0 for bit in manual.SHUTDOWN_BITS)
    return there and all(bench.put("Shutdown", 1 << bit) == manual.RANGE_ERROR for bit in (1, 6, 7))


@rule("PWM Limit(36), Goal PWM(100)")
def pwm_limit(bench: Bench) -> bool:
    """Goal PWM cannot exceed the PWM Limit, and starts there."""
    bench.put("PWM Limit", 300)
    bench.host.ask(1, manual.REBOOT)
    return (
        bench.get("Goal PWM") == 300
        and bench.put("Goal PWM", 301) == manual.LIMIT_ERROR
        and not bench.put("Goal PWM", -300)
    )


@rule("PWM Limit(36), Goal PWM(100)")
def goal_pwm_holds_less(bench: Bench) -> bool:
    """In position control Goal PWM limits the output: with a tenth of it a servo gives way to a quarter of its hold."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: -0.35))
    time.sleep(0.1)
    holds = abs(bench.get("Present Position", signed=True) - 1000) < 5
    bench.put("Goal PWM", 88)
    return holds and bench.until(lambda: bench.get("Present Position", signed=True) < 990)


@rule("Velocity Limit(44), Goal Velocity(104)")
def velocity_limit(bench: Bench) -> bool:
    """Goal Velocity cannot exceed the Velocity Limit."""
    bench.put("Velocity Limit", 50)
    return bench.put("Goal Velocity", 51) == manual.LIMIT_ERROR and bench.put("Goal Velocity", -50) == 0


@rule("Min/Max Position Limit(48, 52)")
def position_limits(bench: Bench) -> bool:
    """Goals of Position Control are bounded by the limits, those of extended position control by 256 turns."""
    bench.put("Max Position Limit", 2000)
    one_turn = bench.put("Goal Position", 2001)
    bench.put("Operating Mode", 4)
    many, beyond = bench.put("Goal Position", -1_048_575), bench.put("Goal Position", 1_048_576)
    return (one_turn, many, beyond) == (manual.LIMIT_ERROR, 0, manual.RANGE_ERROR)


@rule("Startup Configuration(60)")
def startup_torque(bench: Bench) -> bool:
    """With Startup Torque On the torque is on after a reboot."""
    bench.put("Startup Configuration", 1)
    bench.host.ask(1, manual.REBOOT)
    return bench.get("Torque Enable") == 1


@rule("Status Return Level(68)")
def return_level_0(bench: Bench) -> bool:
    """At level 0 pings alone are answered; everything is done all the same."""
    bench.put("Status Return Level", 0)
    silent = not bench.whisper("LED", 1) and not bench.host.ask(1, manual.READ, _two(65, 1))
    pinged = len(bench.host.ask(1, manual.PING)) == 1
    bench.whisper("Status Return Level", 2)
    return silent and pinged and bench.get("LED") == 1


@rule("Status Return Level(68)")
def return_level_1(bench: Bench) -> bool:
    """At level 1 pings and reads are answered."""
    bench.put("Status Return Level", 1)
    return not bench.whisper("LED", 1) and bench.get("LED") == 1


@rule("Bus Watchdog(98)")
def watchdog(bench: Bench) -> bool:
    """Without packets for so long, with torque on, it stops, shows -1, clears profiles and refuses goals until 0."""
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
def watchdog_without_torque(bench: Bench) -> bool:
    """Without torque it does not watch."""
    bench.put("Bus Watchdog", 2)
    time.sleep(0.2)
    return bench.get("Bus Watchdog", signed=True) == 2


@rule("Profile Velocity(112), Profile Acceleration(108)")
def profile(bench: Bench) -> bool:
    """A velocity-based profile is no faster than Profile Velocity."""
    bench.extended()
    bench.put("Profile Velocity", 50)
    bench.put("Goal Position", 5000)
    bench.until(lambda: bench.get("Moving") == 1)
    fastest = max(bench.get("Present Velocity", signed=True) for _ in range(40))
    return 45 <= fastest <= 51


@rule("Goal Position(116), Present Position(132)")
def turns(bench: Bench) -> bool:
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
def realtime_tick(bench: Bench) -> bool:
    """Milliseconds are counted."""
    first, began = bench.get("Realtime Tick"), time.monotonic()
    time.sleep(0.2)
    passed = (bench.get("Realtime Tick") - first) % 32768
    return 0.5 < passed / (1e3 * (time.monotonic() - began)) < 1.5


@rule("Moving(122), Moving Status(123)")
def moving(bench: Bench) -> bool:
    """Both tell a motion and its end, In-Position once it has arrived."""
    bench.extended()
    bench.put("Profile Velocity", 60)
    bench.put("Goal Position", 1600)
    begun = bench.until(lambda: bench.get("Moving") == 1 and bench.get("Moving Status") & 2 != 0)
    ended = bench.until(lambda: bench.get("Moving") == 0 and bench.get("Moving Status") & 3 == 1)
    return begun and ended


@rule("Present Load(126)")
def present_load(bench: Bench) -> bool:
    """The load is that of the torque held, positive where it is held towards larger positions."""
    bench.extended()
    bench.bus.apply(lambda: setattr(bench.first, "torque", lambda position: -0.7))
    return bench.until(lambda: abs(bench.get("Present Load", signed=True) - 500) < 30)


@rule("Indirect Address, Indirect Data")
def indirect(bench: Bench) -> bool:
    """Indirect Data stands for the registers whose addresses are mapped, for reading and for writing."""
    for n in range(4):
        bench.put(f"Indirect Address {n + 2}", 116 + n)
    bench.put("Indirect Address 1", 65)
    bench.put("Indirect Data 1", 1)
    bench.put("Operating Mode", 4)
    error = bench.host.write(1, ROWS["Indirect Data 2"].address, 4, 1024)
    return bench.get("LED") == 1 and not error and bench.get("Goal Position") == 1024
