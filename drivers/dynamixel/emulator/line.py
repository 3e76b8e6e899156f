"""Replies of servos on one line to an instruction packet. Reads no clock."""

from collections.abc import Sequence

from tendond.drivers.dynamixel.emulator.protocol import (
    BROADCAST,
    Error,
    Instruction,
    Packet,
    fast_status,
    status,
)
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.reading import ALERT

RESET_ALL = b"\xff"


class ServoLine:
    """Servos that share a line.

    Attributes:
        knows_fast: the servos' firmware knows Fast Sync Read.
    """

    def __init__(self) -> None:
        self.knows_fast = True

    def reply(self, servos: Sequence[EmulatedServo], packet: Packet) -> tuple[bytes, float]:
        """Return the reply and its delay [s]; empty without a reply.

        Args:
            servos: servos that receive the packet; several may have the same id.
            packet: from the host.
        """
        if packet.id != BROADCAST:
            return self._addressed(servos, packet)
        for servo in servos:
            servo.packet_received()
        if not packet.intact:
            return b"", 0.0
        match packet.instruction:
            case Instruction.PING:
                return self._all_ping(servos), _delay(servos)
            case Instruction.SYNC_READ | Instruction.FAST_SYNC_READ:
                return self._sync_read(servos, packet), _delay(servos)
            case Instruction.BULK_READ:
                return self._bulk_read(servos, packet.parameters), _delay(servos)
            case Instruction.SYNC_WRITE:
                _sync_write(servos, packet.parameters)
            case Instruction.BULK_WRITE:
                _bulk_write(servos, packet.parameters)
            case Instruction.FACTORY_RESET if packet.parameters == RESET_ALL:
                pass  # not for all at once
            case _:
                for servo in servos:
                    _carry_out(servo, packet)
        return b"", 0.0

    def _addressed(self, servos: Sequence[EmulatedServo], packet: Packet) -> tuple[bytes, float]:
        for servo in servos:
            if servo.secondary == packet.id:
                servo.packet_received()
                if packet.intact:
                    _carry_out(servo, packet, primary=False)
        replies = []
        for servo in servos:
            if servo.id != packet.id:
                continue
            servo.packet_received()
            if not packet.intact:
                replies.append(status(packet.id, Error.CRC | _alert(servo)))
                continue
            reads = packet.instruction == Instruction.READ
            replies_to_it = packet.instruction == Instruction.PING or servo.replies(reads=reads)
            error, data = _carry_out(servo, packet)
            if replies_to_it:
                replies.append(status(packet.id, error | _alert(servo), data))
        return _collide(replies), _delay(servos)

    def _all_ping(self, servos: Sequence[EmulatedServo]) -> bytes:
        """Reply in the order of the ids, those of one id at the same time."""
        replies: dict[int, list[bytes]] = {}
        for servo in servos:
            replies.setdefault(servo.id, []).append(status(servo.id, _alert(servo), _identity(servo)))
        return b"".join(_collide(replies[identifier]) for identifier in sorted(replies))

    def _sync_read(self, servos: Sequence[EmulatedServo], packet: Packet) -> bytes:
        fast = packet.instruction == Instruction.FAST_SYNC_READ
        if fast and not self.knows_fast:
            return b""
        address, length, asked = _word(packet.parameters), _word(packet.parameters[2:]), packet.parameters[4:]
        blocks = []
        for identifier in asked:
            data = _read(servos, identifier, address, length)
            if data is None:
                break  # each waits for the one before it
            blocks.append((data[0], identifier, data[1]))
        if not fast:
            return b"".join(status(identifier, error, data) for error, identifier, data in blocks)
        return fast_status(blocks, 1 + len(asked) * (length + 4)) if blocks else b""

    def _bulk_read(self, servos: Sequence[EmulatedServo], parameters: bytes) -> bytes:
        replies = b""
        for at in range(0, len(parameters) - 4, 5):
            identifier = parameters[at]
            data = _read(servos, identifier, _word(parameters[at + 1 :]), _word(parameters[at + 3 :]))
            if data is None:
                break
            replies += status(identifier, *data)
        return replies


def _carry_out(servo: EmulatedServo, packet: Packet, *, primary: bool = True) -> tuple[int, bytes]:
    """Carry out an instruction for one servo; return error and data of its reply."""
    parameters = packet.parameters
    match packet.instruction:
        case Instruction.PING:
            return Error.NONE, _identity(servo)
        case Instruction.READ if len(parameters) == 4:
            found = servo.read(_word(parameters), _word(parameters[2:]))
            return (Error.ACCESS, b"") if found is None else (Error.NONE, found)
        case Instruction.WRITE if len(parameters) > 2:
            return servo.write(_word(parameters), parameters[2:], primary=primary), b""
        case Instruction.REG_WRITE if len(parameters) > 2:
            return servo.register(_word(parameters), parameters[2:]), b""
        case Instruction.ACTION:
            return servo.act(), b""
        case Instruction.REBOOT:
            servo.power_up()
            return Error.NONE, b""
        case Instruction.CLEAR:
            return servo.clear(parameters), b""
        case Instruction.FACTORY_RESET if len(parameters) == 1:
            return servo.factory_reset(parameters[0]), b""
    return Error.INSTRUCTION, b""


def _sync_write(servos: Sequence[EmulatedServo], parameters: bytes) -> None:
    address, length = _word(parameters), _word(parameters[2:])
    for at in range(4, len(parameters) - length, length + 1):
        _write(servos, parameters[at], address, parameters[at + 1 : at + 1 + length])


def _bulk_write(servos: Sequence[EmulatedServo], parameters: bytes) -> None:
    at = 0
    while at + 5 <= len(parameters):
        address, length = _word(parameters[at + 1 :]), _word(parameters[at + 3 :])
        data = parameters[at + 5 : at + 5 + length]
        if len(data) == length:
            _write(servos, parameters[at], address, data)
        at += 5 + length


def _write(servos: Sequence[EmulatedServo], identifier: int, address: int, data: bytes) -> None:
    for servo in servos:
        if servo.id == identifier:
            servo.write(address, data)
        elif servo.secondary == identifier:
            servo.write(address, data, primary=False)


def _read(servos: Sequence[EmulatedServo], identifier: int, address: int, length: int) -> tuple[int, bytes] | None:
    """Return error byte and data of one servo's block of a common reply."""
    servo = next((one for one in servos if one.id == identifier), None)
    if servo is None or not servo.replies(reads=True):
        return None
    data = servo.read(address, length)
    return None if data is None else (_alert(servo), data)


def _collide(replies: Sequence[bytes]) -> bytes:
    """Combine replies that are written at the same time: a 0 on the line is dominant."""
    if len(replies) < 2:
        return b"".join(replies)
    longest = max(map(len, replies))
    padded = [reply.ljust(longest, b"\xff") for reply in replies]
    return bytes(_all_ones(column) for column in zip(*padded, strict=True))


def _all_ones(column: tuple[int, ...]) -> int:
    together = 0xFF
    for byte in column:
        together &= byte
    return together


def _identity(servo: EmulatedServo) -> bytes:
    return servo.value(table.MODEL).to_bytes(2, "little") + bytes([servo.value(table.FIRMWARE)])


def _alert(servo: EmulatedServo) -> int:
    return ALERT if servo.alert else 0


def _delay(servos: Sequence[EmulatedServo]) -> float:
    return max((servo.return_delay for servo in servos), default=0.0)


def _word(data: bytes) -> int:
    return int.from_bytes(data[:2], "little")
