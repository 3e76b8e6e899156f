"""Poses of the tip: targets with a direction, the shapes that reach them, and their tracking with all tendons."""
