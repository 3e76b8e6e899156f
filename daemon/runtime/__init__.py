"""The loop and its I/O: clock, bus, requests, planning process."""
