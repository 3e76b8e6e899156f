"""Minima of the general rod's energy: equilibria, and steps that always have a solution."""
