"""True if the rig is the one that the configuration describes: its rest, its tendons, its tracking."""
