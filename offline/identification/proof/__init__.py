"""Proof on simulated rigs whose parameters are known."""
