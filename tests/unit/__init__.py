"""Unit tests: one process, no network."""
