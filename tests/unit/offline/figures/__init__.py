"""Figures, tables and movies of runs."""
