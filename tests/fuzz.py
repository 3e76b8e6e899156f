"""Fuzz everything that parses bytes from outside: bus payloads, configurations, log files.

    python -m tests.fuzz 1000000        so many inputs, in one process

Inputs are valid ones with bytes changed, cut, doubled, swapped and joined, and bytes from nowhere. Each must give a
value or one of the documented errors, in bounded time; anything else ends the run with the input in hexadecimal.
"""

import json
import random
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from tendond.cli.common import load_config
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import load
from tendond.schemas.base import Schema
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.messages import Mode, SensorReading, SimulatorTruth, TendonCommand, TendonState, TipPose
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode
from tests.unit.offline.records import cycle_record, write_log

FOUR = (0.0, 1e-3, -0.02, 5e-324)
MESSAGES: tuple[Schema, ...] = (
    TipPose(seq=1, stamp_ns=2, position=(0.1, -0.2, 3e-5), orientation=(1.0, 0.0, 0.0, 0.0)),
    TendonState(seq=1, stamp_ns=2, displacement=FOUR, tension=FOUR, fault="servo 2: überlast"),
    TendonCommand(seq=1, stamp_ns=2, pose_seq=None, displacement=FOUR, tension=FOUR, armed=True),
    SensorReading(seq=1, stamp_ns=2, rows=((0.1, -0.2, 3e-5), None, FOUR)),
    SimulatorTruth(
        seq=1,
        stamp_ns=2,
        position=(0.0,) * 3,
        velocity=(0.0,) * 3,
        displacement=FOUR,
        tension=FOUR,
        tip_force=(0.0,) * 3,
    ),
    ControlRequest(action=ControlAction.ARM),
    ControlRequest(action=ControlAction.LAW, law="backstepping"),
    ControlRequest(action=ControlAction.REFERENCE, reference=ReferenceSection(across=0.3)),
    ControlRequest(action=ControlAction.SET, settings={"control.laws.backstepping.alpha1": 900.0}),
    ControlRequest(action=ControlAction.JOG, jog=-0.05),
    ControlReply(done=True, message="armed"),
)
REASONS = {
    "too large", "malformed", "not finite", "wrong version", "bad quaternion",
}  # fmt: skip
SPICE = (
    b"NaN", b"-Infinity", b"1e999", b"null", b"[]", b"{}", b'"', b"\x00", b"\xff\xfe", b"\\ud800", b"9" * 400, b"true",
    b"[" * 200, b'{"a":' * 50, b"-0", b"1e-320", b"\xf0\x9f", b"version", b"seq", b"=", b"\n[", b"0x", b"inf", b"nan",
)  # fmt: skip
KINDS = tuple({type(message): None for message in MESSAGES})
SECTIONS = "".join(f"[{name}]\n" for name in RigConfig.model_fields if name not in {"servo", "sensors"})
SECTIONS += '[[sensors]]\nname = "skin"\nkind = "markers"\nat = [0.1, 0.2]\noffset = [0.0, 0.01, 0.0]\nnoise = 1e-3\n'
CONFIGS = (PAPER.encode(), SECTIONS.encode())


def mutated(seed: bytes, draw: random.Random) -> bytes:
    """`seed` after a few changes; single ones and other digits are common, or little would ever be read."""
    data = bytearray(seed)
    for _ in range(draw.choice((1, 1, 1, 2, 4))):
        at = draw.randint(0, len(data))
        match draw.choice((0, 0, 0, 0, 1, 2, 3, 4, 5, 6)):
            case 0 if data:
                digit = data[at - 1] in b"0123456789"
                data[at - 1] = draw.choice(b"0123456789-.e") if digit else data[at - 1] ^ 1 << draw.randrange(8)
            case 1:
                del data[at : at + draw.randint(1, 20)]
            case 2:
                data[at:at] = draw.choice(SPICE)
            case 3:
                data[at:at] = draw.randbytes(draw.randint(1, 8))
            case 4 if data:
                start = draw.randrange(len(data))
                data[at:at] = data[start : start + draw.randint(1, 60)]
            case 5:
                data = data[:at]
            case _:
                data[at : at + draw.randint(1, 12)] = draw.choice(SPICE)
    return bytes(data)


def promised(held: bool, what: object) -> None:
    """A promise that is not an error's type.

    Raises:
        AssertionError: it was not held.
    """
    if not held:
        raise AssertionError(what)


def bus(data: bytes) -> str:
    """A payload, read as every kind of message."""
    outcome = ""
    for kind in KINDS:
        try:
            message = decode(kind, data)
        except UnreadableError as error:
            promised(error.reason in REASONS, error)
            outcome = outcome or error.reason
        else:
            promised(decode(kind, encode(message)) == message, message)  # what is admitted can be sent on, unchanged
            outcome = "read"
    return outcome


def configuration(data: bytes) -> str:
    """A rig's TOML, by the way that the command line takes."""
    path = FOLDER / "rig.toml"
    path.write_bytes(data)
    try:
        load_config(path)
    except ConfigError as error:
        promised(str(error).startswith(str(path)), error)
        return "refused"
    return "read"


def log(data: bytes) -> str:
    """A log file."""
    path = FOLDER / "fuzzed.mcap"
    path.write_bytes(data)
    try:
        loaded = load(path)
    except LogError as error:
        promised("\n" not in str(error), error)
        return "refused"
    return "whole" if loaded.complete else "to where it is damaged"


FOLDER = Path(tempfile.gettempdir())


def targets() -> list[tuple[str, float, Callable[[bytes], str], list[bytes]]]:
    """Name, share of the inputs, parser, seeds."""
    short = write_log(FOLDER / "seed.mcap", [cycle_record(tick, mode=Mode.IDLE) for tick in range(3)])
    return [
        ("bus", 0.94, bus, [encode(message) for message in MESSAGES]),
        ("configuration", 0.05, configuration, list(CONFIGS)),
        ("log", 0.01, log, [short.read_bytes()]),
    ]


def run(count: int, seed: int) -> dict[str, dict[str, int]]:
    """Fuzz with `count` inputs; what became of them, by parser.

    Raises:
        AssertionError: an error that is not documented; the message has the input.
    """
    global FOLDER
    draw = random.Random(seed)
    outcomes: dict[str, Counter[str]] = {}
    with tempfile.TemporaryDirectory() as folder:
        FOLDER = Path(folder)
        for name, share, parse, seeds in targets():
            counter = outcomes.setdefault(name, Counter())
            for _ in range(max(1, round(share * count))):
                junk = draw.random() < 0.05
                data = draw.randbytes(draw.randint(0, 200)) if junk else mutated(draw.choice(seeds), draw)
                try:
                    counter[parse(data)] += 1
                except Exception as error:
                    shown = data.hex() if len(data) < 4000 else f"{len(data)} bytes"
                    raise AssertionError(f"{name}: {type(error).__name__}: {error}\ninput: {shown}") from error
    return {name: dict(counter) for name, counter in outcomes.items()}


def main() -> None:
    """See the module."""
    if len(sys.argv) != 2 or not sys.argv[1].isdigit():
        raise SystemExit(__doc__)
    started = time.monotonic()
    outcomes = run(int(sys.argv[1]), seed=int(time.time()))
    print(json.dumps({"seconds": round(time.monotonic() - started, 1), **outcomes}))


if __name__ == "__main__":
    main()
