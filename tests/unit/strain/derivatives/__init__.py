"""Derivatives of the general rod: linear models, second derivatives."""
