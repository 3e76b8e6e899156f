"""Dynamixel servos that are not there: real bytes on a real pseudo-terminal, by the manual and not by the SDK."""
