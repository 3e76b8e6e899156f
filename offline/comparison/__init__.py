"""Comparison of runs: their metrics side by side, repeats with their spread, tables in several formats."""
