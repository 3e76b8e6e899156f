"""Teach-in: poses that somebody has shown, as a reference to play."""
