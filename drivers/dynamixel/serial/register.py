"""One register of a control table."""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Register:
    """One entry: name as in the manual, address, bytes, and whether it is signed, in EEPROM or read-only.

    Entries are equal by their name: those of two models stand for the same quantity.

    A servo accepts values from `minimum` to `maximum`, in units of the register; `bits`, where not 0, are those that
    may be set, and `values`, where not empty, the only ones allowed.
    """

    name: str
    address: int = field(compare=False)
    size: int = field(compare=False)
    minimum: int = field(compare=False)
    maximum: int = field(compare=False)
    initial: int = field(default=0, compare=False)
    eeprom: bool = field(default=False, compare=False)
    read_only: bool = field(default=False, compare=False)
    bits: int = field(default=0, compare=False)
    values: tuple[int, ...] = field(default=(), compare=False)

    @property
    def signed(self) -> bool:
        """Two's complement."""
        return self.minimum < 0

    def accepts(self, value: int) -> bool:
        """Return true for a value that the manual allows to be written."""
        if self.values:
            return value in self.values
        return self.minimum <= value <= self.maximum and not (self.bits and value & ~self.bits)

    def to_bytes(self, value: int) -> bytes:
        """Little-endian.

        Raises:
            OverflowError: the value does not fit.
        """
        return value.to_bytes(self.size, "little", signed=self.signed)

    def from_bytes(self, data: bytes) -> int:
        """The value in the register's bytes."""
        return int.from_bytes(data, "little", signed=self.signed)
