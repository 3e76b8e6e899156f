"""Robots from configurations, and what follows from a description."""
