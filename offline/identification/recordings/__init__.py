"""Recordings that a fit uses: reading them from logs, weights on the tip, and checks."""
