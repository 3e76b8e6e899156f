"""Recorded logs that every version must replay, and the command that makes them anew."""
