"""The servos' serial bus: port, packets, control table, readings."""
