"""Control table of an emulated servo as bytes: registers, Indirect Addresses, EEPROM and RAM."""

from collections.abc import Iterator

from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.table import Register

_AT = {register.address: register for register in table.REGISTERS}
_POINTER = {data.address: pointer for pointer, data in zip(table.INDIRECT_ADDRESSES, table.INDIRECT_DATA, strict=True)}
"""The Indirect Address of each byte of Indirect Data."""


class ControlTable:
    """Bytes of the control table, with the factory's values."""

    def __init__(self) -> None:
        self._data = bytearray(table.TABLE_SIZE)
        self.reset(eeprom=True)
        self.reset(eeprom=False)

    def reset(self, *, eeprom: bool) -> None:
        """Reset EEPROM or RAM to the initial values."""
        for register in table.REGISTERS:
            if register.eeprom is eeprom:
                self.store(register, register.initial)

    def value(self, register: Register) -> int:
        """Return the value of a register."""
        return register.from_bytes(bytes(self._data[register.address : register.address + register.size]))

    def store(self, register: Register, value: int) -> None:
        """Set a register, without any rule."""
        self._data[register.address : register.address + register.size] = register.to_bytes(value)

    def read(self, address: int, length: int) -> bytes | None:
        """Read bytes from a register on, 0 in gaps; none where no register begins or the table ends."""
        if length == 0 or address + length > table.TABLE_SIZE or address not in _AT:
            return None
        return bytes(self._data[self._target(at)] for at in range(address, address + length))

    def _target(self, address: int) -> int:
        """Resolve an address: Indirect Data stands for the byte that its Indirect Address names."""
        pointer = _POINTER.get(address)
        return address if pointer is None else self.value(pointer)

    def items(self, address: int, data: bytes) -> Iterator[tuple[Register | None, bytes]]:
        """Yield the registers of a write with their bytes, in order; none where no register begins."""
        while data:
            at = self._target(address)
            register = _AT.get(at)
            if register is None:
                yield None, data
                return
            size = register.size
            if at != address and any(self._target(address + i) != at + i for i in range(min(size, len(data)))):
                yield None, data  # only a part of the register is mapped
                return
            yield register, data[:size]
            address, data = address + size, data[size:]
