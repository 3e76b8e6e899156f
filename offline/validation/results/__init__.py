"""Figures of a validation: errors, repeatability, report and drawings."""
