"""Rules of Protocol 2.0: packets, errors, instructions."""

import struct

from tests.conformance import manual
from tests.conformance.bench import ServoBench
from tests.conformance.host import crc, packet, write_parameters
from tests.conformance.rules.table import rule, two


@rule("Protocol 2.0: packets")
def examples(bench: ServoBench) -> bool:
    """The packets that the manual prints have the CRC that it prints."""
    wires = [bytes.fromhex(text) for _, text in manual.EXAMPLES]
    return all(crc(wire[:-2]) == int.from_bytes(wire[-2:], "little") for wire in wires) and packet(1, 1) == wires[0]


@rule("Protocol 2.0: packets")
def stuffing(bench: ServoBench) -> bool:
    """FF FF FD within parameters is stuffed, in instructions and replies."""
    bench.put("Operating Mode", 4)
    headed = int.from_bytes(b"\xff\xff\xfd\xff", "little", signed=True)
    return bench.put("Goal Position", headed) == 0 and bench.get("Goal Position", signed=True) == headed


@rule("Protocol 2.0: error")
def wrong_crc(bench: ServoBench) -> bool:
    """Packets with a wrong CRC have no effect; the reply is CRC Error."""
    broken = bytearray(packet(1, manual.WRITE, write_parameters(65, 1, 1)))
    broken[-1] ^= 0xFF
    (reply,) = bench.host.send(bytes(broken))
    return reply.error == manual.CRC_ERROR and bench.get("LED") == 0


@rule("Protocol 2.0: error")
def undefined_instruction(bench: ServoBench) -> bool:
    """Undefined instructions have the reply Instruction Error."""
    (reply,) = bench.host.ask(1, 0x77)
    return reply.error == manual.INSTRUCTION_ERROR


@rule("Protocol 2.0: error")
def alert(bench: ServoBench) -> bool:
    """A hardware error sets the alert bit of every reply, beside its error."""
    before = bench.host.ask(1, manual.PING)[0].alert
    bench.bus.apply(lambda: bench.first.fail(5))
    refused = bench.host.ask(1, manual.WRITE, write_parameters(69, 1, 0))[0]
    return not before and refused.alert and refused.error == manual.ACCESS_ERROR


@rule("Protocol 2.0: Ping")
def ping(bench: ServoBench) -> bool:
    """Ping replies with model number and firmware; an absent id does not reply."""
    (reply,) = bench.host.ask(1, manual.PING)
    return reply.data[:2] == (1060).to_bytes(2, "little") and len(reply.data) == 3 and not bench.host.ask(9, 1)


@rule("Protocol 2.0: Ping")
def ping_all(bench: ServoBench) -> bool:
    """Ping to all has a reply from each, in the order of the ids, whatever their Status Return Level."""
    bench.put("Status Return Level", 0, 2)
    return [reply.id for reply in bench.host.ask(manual.BROADCAST, manual.PING)] == [1, 2]


@rule("Protocol 2.0: Packet ID")
def broadcast_write(bench: ServoBench) -> bool:
    """Write to all is carried out by each without a reply; read of all has no reply."""
    silent = not bench.host.ask(manual.BROADCAST, manual.WRITE, write_parameters(65, 1, 1))
    unread = not bench.host.ask(manual.BROADCAST, manual.READ, two(65, 1))
    return silent and unread and (bench.get("LED", 1), bench.get("LED", 2)) == (1, 1)


@rule("Protocol 2.0: Read")
def long_read(bench: ServoBench) -> bool:
    """Read from a register on may span others and gaps, but not the table's end."""
    whole = bench.host.read(1, 64, 83)
    beyond = bench.host.read(1, 661, 2)
    return whole.error == 0 and len(whole.data) == 83 and beyond.error == manual.ACCESS_ERROR


@rule("Protocol 2.0: Write")
def long_write(bench: ServoBench) -> bool:
    """Write may span registers that follow each other."""
    (reply,) = bench.host.ask(1, manual.WRITE, struct.pack("<HII", 108, 7, 8))
    return reply.error == 0 and (bench.get("Profile Acceleration"), bench.get("Profile Velocity")) == (7, 8)


@rule("Protocol 2.0: Reg Write, Action")
def reg_write(bench: ServoBench) -> bool:
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
def action_for_all(bench: ServoBench) -> bool:
    """An action for all carries out what each has registered, at once."""
    for one in (1, 2):
        bench.host.ask(one, manual.REG_WRITE, write_parameters(65, 1, 1))
    silent = not bench.host.ask(manual.BROADCAST, manual.ACTION)
    return silent and (bench.get("LED", 1), bench.get("LED", 2)) == (1, 1)


@rule("Protocol 2.0: Reg Write, Action")
def empty_action(bench: ServoBench) -> bool:
    """An action without a registered write is an Instruction Error."""
    return bench.host.ask(1, manual.ACTION)[0].error == manual.INSTRUCTION_ERROR


@rule("Protocol 2.0: Factory Reset")
def factory_reset(bench: ServoBench) -> bool:
    """Option 1 keeps the id, option 2 id and rate; the rest is as in the factory."""
    bench.put("Return Delay Time", 5, 2)
    bench.put("Shutdown", 0, 2)
    (reply,) = bench.host.ask(2, manual.FACTORY_RESET, b"\x02")
    return not reply.error and (bench.get("Return Delay Time", 2), bench.get("Shutdown", 2)) == (250, 52)


@rule("Protocol 2.0: Factory Reset")
def factory_reset_of_all(bench: ServoBench) -> bool:
    """Reset of everything is not for all at once."""
    bench.put("Return Delay Time", 5)
    bench.host.ask(manual.BROADCAST, manual.FACTORY_RESET, b"\xff")
    return bench.get("Return Delay Time") == 5 and bench.get("ID", 2) == 2


@rule("Protocol 2.0: Reboot")
def reboot(bench: ServoBench) -> bool:
    """Reboot has a reply; RAM has its initial values, EEPROM is kept, the torque is off."""
    bench.put("Return Delay Time", 5)
    bench.extended()
    bench.put("LED", 1)
    (reply,) = bench.host.ask(1, manual.REBOOT)
    kept = (bench.get("Return Delay Time"), bench.get("Operating Mode")) == (5, 4)
    return not reply.error and kept and (bench.get("LED"), bench.get("Torque Enable")) == (0, 0)


@rule("Protocol 2.0: Clear")
def clear(bench: ServoBench) -> bool:
    """Clear takes the whole turns off Present Position, of a servo that stands still."""
    bench.put("Operating Mode", 4)
    bench.bus.apply(lambda: bench.first._shaft.place(1000.0 + 3 * 4096))
    bench.until(lambda: bench.get("Present Position", signed=True) == 1000 + 3 * 4096)
    (reply,) = bench.host.ask(1, manual.CLEAR, manual.CLEAR_TURNS)
    return not reply.error and bench.get("Present Position", signed=True) == 1000


@rule("Protocol 2.0: Clear")
def clear_in_motion(bench: ServoBench) -> bool:
    """Clear of a servo that moves is a Result Fail."""
    bench.extended()
    bench.put("Profile Velocity", 20)
    bench.put("Goal Position", 100_000)
    moving = bench.until(lambda: bench.get("Moving") == 1)
    (reply,) = bench.host.ask(1, manual.CLEAR, manual.CLEAR_TURNS)
    return moving and reply.error == manual.RESULT_FAIL


@rule("Protocol 2.0: Sync Read, Sync Write")
def sync(bench: ServoBench) -> bool:
    """One packet writes, one reads the same registers of several servos, each with a reply of its own."""
    bench.host.ask(manual.BROADCAST, manual.SYNC_WRITE, two(112, 4) + b"\x01\x10\0\0\0\x02\x20\0\0\0")
    replies = bench.host.ask(manual.BROADCAST, manual.SYNC_READ, two(112, 4) + b"\x01\x02")
    return [(one.id, int.from_bytes(one.data, "little")) for one in replies] == [(1, 16), (2, 32)]


@rule("Protocol 2.0: Bulk Read, Bulk Write")
def bulk(bench: ServoBench) -> bool:
    """One packet writes, one reads different registers of several servos."""
    items = b"\x01" + two(32, 2) + b"\x78\x00" + b"\x02" + two(31, 1) + b"\x50"
    bench.host.ask(manual.BROADCAST, manual.BULK_WRITE, items)
    replies = bench.host.ask(manual.BROADCAST, manual.BULK_READ, b"\x01" + two(32, 2) + b"\x02" + two(31, 1))
    return [(one.id, int.from_bytes(one.data, "little")) for one in replies] == [(1, 120), (2, 80)]


@rule("Protocol 2.0: Fast Sync Read")
def fast_sync(bench: ServoBench) -> bool:
    """One packet has the replies of all: error, id, data and CRC of each."""
    (reply,) = bench.host.ask(manual.BROADCAST, manual.FAST_SYNC_READ, two(7, 1) + b"\x01\x02")
    # the first error stands apart; id, data, CRC of the first, error, id, data of the second, whose CRC is the packet's
    return reply.id == manual.BROADCAST and reply.data[:2] == b"\x01\x01" and reply.data[4:7] == b"\x00\x02\x02"
