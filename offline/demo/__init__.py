"""Demonstrations: real processes on a real bus, in real time, with a report made from the log alone."""
