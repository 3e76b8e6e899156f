"""tendond drives a tendon-driven continuum robot. Its parts are the linked top-level folders."""

__version__ = "0.1.0"


class TendondError(Exception):
    """Base of everything that tendond raises on purpose: one line that says what, where, and what to do."""
