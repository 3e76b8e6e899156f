"""Simulator in the loop: real processes on real Zenoh."""
