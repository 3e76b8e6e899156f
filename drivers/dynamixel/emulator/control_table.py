"""Control table of an emulated servo as bytes: registers, Indirect Addresses, EEPROM and RAM."""

from collections.abc import Iterator

from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.register import Register


class ControlTable:
    """Bytes of the control table, with the factory's values.

    Args:
        model: of the servo; registers are named by any model's entry.
    """

    def __init__(self, model: ServoModel) -> None:
        self._model = model
        self._at = {register.address: register for register in model.registers}
        named = {register.name: register for register in model.registers}
        self._pointer = {
            data.address: named[name.replace("Data", "Address")]
            for name, data in named.items()
            if name.startswith("Indirect Data")
        }
        self._data = bytearray(model.table_size)
        self.reset(eeprom=True)
        self.reset(eeprom=False)

    def reset(self, *, eeprom: bool) -> None:
        """Reset EEPROM or RAM to the initial values."""
        for register in self._model.registers:
            if register.eeprom is eeprom:
                self.store(register, register.initial)

    def value(self, register: Register) -> int:
        """Return the value of a register."""
        entry = self._model.entry(register)
        return entry.from_bytes(bytes(self._data[entry.address : entry.address + entry.size]))

    def store(self, register: Register, value: int) -> None:
        """Set a register, without any rule."""
        entry = self._model.entry(register)
        self._data[entry.address : entry.address + entry.size] = entry.to_bytes(value)

    def read(self, address: int, length: int) -> bytes | None:
        """Read bytes from a register on, 0 in gaps; none where no register begins or the table ends."""
        if length == 0 or address + length > self._model.table_size or address not in self._at:
            return None
        return bytes(self._data[self._target(at)] for at in range(address, address + length))

    def _target(self, address: int) -> int:
        """Resolve an address: Indirect Data stands for the byte that its Indirect Address names."""
        pointer = self._pointer.get(address)
        return address if pointer is None else self.value(pointer)

    def items(self, address: int, data: bytes) -> Iterator[tuple[Register | None, bytes]]:
        """Yield the registers of a write with their bytes, in order; none where no register begins."""
        while data:
            at = self._target(address)
            register = self._at.get(at)
            if register is None:
                yield None, data
                return
            size = register.size
            if at != address and any(self._target(address + i) != at + i for i in range(min(size, len(data)))):
                yield None, data  # only a part of the register is mapped
                return
            yield register, data[:size]
            address, data = address + size, data[size:]
