"""Learned correction of a model's tip, bounded and off outside of its data."""
