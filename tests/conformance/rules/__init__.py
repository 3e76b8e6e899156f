"""Rules that the manual states in words: the protocol's first, then the registers' in the order of their addresses."""

from tests.conformance.rules import eeprom as eeprom
from tests.conformance.rules import protocol as protocol
from tests.conformance.rules import ram as ram
from tests.conformance.rules import table
from tests.conformance.rules.table import Rule as Rule

RULES = sorted(table.RULES, key=lambda one: not one[0].startswith("Protocol"))
"""Section of the manual, and rule."""
