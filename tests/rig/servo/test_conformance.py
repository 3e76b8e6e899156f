"""The emulated servos do what the manual says: `python -m tests.conformance` prints the same as a page."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.serial import table
from tests.conformance import manual
from tests.conformance.bench import ServoBench, bench
from tests.conformance.manual import Row
from tests.conformance.registers import check, undefined
from tests.conformance.rules import RULES, Rule

pytestmark = pytest.mark.rig

FEW = [row for row in manual.rows() if not row.name.startswith("Indirect") or row.name.endswith((" 1", " 28", " 56"))]


@pytest.fixture
def new(tmp_path: Path) -> Iterator[ServoBench]:
    with bench(tmp_path) as one:
        yield one


@pytest.mark.parametrize("row", FEW, ids=lambda row: row.name)
def test_a_register_has_the_manuals_size_initial_value_range_and_access(new: ServoBench, row: Row) -> None:
    assert list(check(new, row)) == []


@pytest.mark.parametrize(("section", "rule"), RULES, ids=[rule.__name__ for _, rule in RULES])
def test_a_rule_of_the_manual_holds(new: ServoBench, section: str, rule: Rule) -> None:
    assert rule(new), f"{section}: {rule.__doc__}"


def test_addresses_at_which_nothing_is_are_refused(new: ServoBench) -> None:
    assert [one for address in manual.UNDEFINED for one in undefined(new, address)] == []


def test_the_drivers_table_is_the_manuals() -> None:
    """Two people's reading of the same page would be better; these are two typings of it."""
    ours = {one.address: one for one in table.REGISTERS}
    rows = manual.rows()
    assert [row.address for row in rows] == sorted(ours)
    for row in rows:
        one = ours[row.address]
        assert (one.name, one.size, one.read_only, one.eeprom) == (row.name, row.size, not row.writable, row.eeprom)
        assert row.initial is None or one.initial == row.initial


def test_no_packet_ends_the_servos_thread(new: ServoBench) -> None:
    for instruction in range(256):
        for parameters in (b"", b"\x00", b"\xff" * 3, b"\x07\x00\xff", bytes(5), b"\x08\x00\x07" * 4):
            new.host.patience = 0.002
            new.host.ask(1, instruction, parameters)
    new.host.patience = 0.2
    assert new.bus.alive
    assert new.bus.errors == []


def test_a_mistake_within_the_emulator_is_kept_and_the_servos_go_on(tmp_path: Path) -> None:
    with bench(tmp_path) as one:
        one.bus.apply(lambda: setattr(one.first, "torque", lambda position: 1 / 0))
        assert one.bus.servos[1].id == 2
        assert one.until(lambda: any(isinstance(error, ZeroDivisionError) for error in one.bus.errors))
        one.bus.apply(lambda: setattr(one.first, "torque", lambda position: 0.0))
        assert len(one.host.ask(2, manual.PING)) == 1
        one.bus.errors.clear()
