"""Compare the emulated servos with the manual: `python -m tests.conformance` prints a page; 1 if they differ."""

import sys
import tempfile
from pathlib import Path

from tests.conformance import manual
from tests.conformance.bench import bench
from tests.conformance.registers import check, undefined
from tests.conformance.rules import RULES

HEAD = """# The emulated servos and the manual

Made by `python -m tests.conformance`, which asks the emulated servos over a pseudo-terminal with a host of its own
([host.py](../tests/conformance/host.py)) and the manual's tables ([manual.py](../tests/conformance/manual.py)), neither
of which knows the driver, the SDK or the emulator. Source: ROBOTIS e-Manual, XL430-W250-T and Protocol 2.0.
"""
LEFT_OUT = """
## Not emulated

Control Table Backup (0x20) and RAM Restore, firmware recovery, Protocol 1.0 and the RC protocols (Protocol Type other
than 2), the gains of the control loops and feedforward (kept, without effect), the LED's blinking after a shutdown.
Open in the manual, and decided here: packets for other servos do not feed the Bus Watchdog, those for all
do; the supply below which a servo restarts is 5.0 V; gears and the shaft's lag are guesses.
"""


def main() -> int:
    """Print the page; return the exit status."""
    wrong = 0
    print(HEAD)
    print(
        "## Registers\n\n| address | name | access | initial | range | found |\n| --- | --- | --- | --- | --- | --- |"
    )
    for row in manual.rows():
        with tempfile.TemporaryDirectory() as folder, bench(Path(folder)) as one:
            differences = list(check(one, row))
        wrong += bool(differences)
        bounds = "-" if row.low is None else f"{row.low} to {row.high}"
        initial = "-" if row.initial is None else row.initial
        access = "RW" if row.writable else "R"
        print(
            f"| {row.address} | {row.name} | {access} | {initial} | {bounds} | {'; '.join(differences) or 'as there'} |"
        )
    with tempfile.TemporaryDirectory() as folder, bench(Path(folder)) as one:
        found = [f"{address}: {one_wrong}" for address in manual.UNDEFINED for one_wrong in undefined(one, address)]
    wrong += bool(found)
    print(f"\nAddresses without a register: {'; '.join(found) or 'Access Error for reading and writing'}.")
    print("\n## Rules\n\n| section | rule | holds |\n| --- | --- | --- |")
    for section, rule in RULES:
        with tempfile.TemporaryDirectory() as folder, bench(Path(folder)) as one:
            holds = rule(one)
        wrong += not holds
        print(f"| {section} | {(rule.__doc__ or rule.__name__).rstrip('.')} | {'yes' if holds else '**no**'} |")
    print(f"\n{len(manual.rows())} registers, {len(RULES)} rules; {wrong} differ.")
    print(LEFT_OUT, end="")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
