"""Tools for servos without a driver: find, set up, calibrate, home."""
