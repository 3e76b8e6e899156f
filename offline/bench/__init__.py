"""Benchmarks: `tendond bench`."""
