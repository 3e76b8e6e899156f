"""The USB adapter of the servos' bus, as Linux shows it."""

from pathlib import Path

DEVICES = Path("/sys/bus/usb-serial/devices")
WANTED_MS = 1


def latency_warning(port: str, devices: Path = DEVICES) -> str:
    """What to say of an adapter that keeps answers back for longer than it has to; empty where nothing is wrong.

    FTDI's chips send what they have received when 62 bytes are there or their latency timer is over, 16 ms as it comes.

    Args:
        port: of the servos; a link to it will do.
        devices: where Linux has the timers, [ms].
    """
    file = devices / Path(port).resolve().name / "latency_timer"
    try:
        timer = int(file.read_text())
    except (OSError, ValueError):
        return ""  # another kind of adapter
    if timer <= WANTED_MS:
        return ""
    return f"{port}: its latency timer is {timer} ms, answers come late: echo {WANTED_MS} > {file}"
