"""USB adapter of the servos' bus, as Linux shows it.

FTDI's chips forward received bytes once there are 62 of them or their latency timer expires, by default after 16 ms.
"""

from pathlib import Path

SYS = Path("/sys")
WANTED_MS = 1

DELAYED_SECONDS = 0.012
"""Reply time above which the adapter delays replies [s]: the default timer takes 16 ms, a register 10 ms on the wire at
9600 bit/s and 1 ms at 57600."""


def latency_timer(port: str, sys: Path = SYS) -> tuple[int, Path] | None:
    """Return the adapter's latency timer [ms] and its file; none for other adapters.

    Args:
        port: port of the servos, or a link to it.
        sys: folder of Linux's devices.
    """
    file = sys / "bus" / "usb-serial" / "devices" / Path(port).resolve().name / "latency_timer"
    try:
        return int(file.read_text()), file
    except (OSError, ValueError):
        return None


def latency_warning(port: str, sys: Path = SYS) -> str:
    """Return a warning for an adapter that delays replies; empty without one.

    Args:
        port, sys: see `latency_timer`.
    """
    found = latency_timer(port, sys)
    if found is None or found[0] <= WANTED_MS:
        return ""
    timer, file = found
    return f"{port}: its latency timer is {timer} ms, replies come late: echo {WANTED_MS} > {file}"
