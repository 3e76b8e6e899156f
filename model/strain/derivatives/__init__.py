"""Derivatives of the general rod: second ones of its shape, and of steps, rests and the tip's acceleration."""
