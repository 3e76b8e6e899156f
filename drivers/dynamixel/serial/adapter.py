"""The USB adapter of the servos' bus, as Linux shows it.

FTDI's chips send what they have received when 62 bytes are there or their latency timer is over, 16 ms as it comes.
"""

from pathlib import Path

SYS = Path("/sys")
WANTED_MS = 1


def latency_timer(port: str, sys: Path = SYS) -> tuple[int, Path] | None:
    """The adapter's timer [ms] and its file; none of another kind of adapter.

    Args:
        port: of the servos; a link to it will do.
        sys: where Linux shows its devices.
    """
    file = sys / "bus" / "usb-serial" / "devices" / Path(port).resolve().name / "latency_timer"
    try:
        return int(file.read_text()), file
    except (OSError, ValueError):
        return None


def latency_warning(port: str, sys: Path = SYS) -> str:
    """What to say of an adapter that keeps answers back for longer than it has to; empty where nothing is wrong.

    Args:
        port, sys: see `latency_timer`.
    """
    found = latency_timer(port, sys)
    if found is None or found[0] <= WANTED_MS:
        return ""
    timer, file = found
    return f"{port}: its latency timer is {timer} ms, answers come late: echo {WANTED_MS} > {file}"
