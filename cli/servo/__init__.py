"""Commands of the servos."""
