"""Experiments: tuned constants with other values."""
