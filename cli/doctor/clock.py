"""Synchronisation of the wall clock: adjtimex(2)."""

import ctypes

TIME_ERROR = 5
TIMEX_BYTES = 256
"""More than struct timex has; with modes = 0, its first field, nothing is changed."""


def is_synchronised() -> bool:
    """Check that the kernel reports the clock as synchronised, by NTP for instance."""
    buffer = ctypes.create_string_buffer(TIMEX_BYTES)
    state = int(ctypes.CDLL(None, use_errno=True).adjtimex(buffer))
    return 0 <= state != TIME_ERROR
