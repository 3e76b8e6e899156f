"""Emulated Dynamixel servos: real bytes on a real pseudo-terminal, by the manual and not by the SDK."""
