"""Rods of measured robots: unknown parameters, and the tips that follow from commands in their order."""
