"""Estimation of a rod's parameters from measured tips."""
