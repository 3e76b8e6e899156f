"""Benchmarks of the general rod: time, textbooks, others' data, robots at random, many at once."""
