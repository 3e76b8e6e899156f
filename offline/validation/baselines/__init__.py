"""Simpler models on the same inputs, to compare the rod with."""
