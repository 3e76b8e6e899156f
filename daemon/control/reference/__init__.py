"""References in space: where the tip can rest, courses there, and their time."""
