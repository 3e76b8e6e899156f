"""Dynamixel servos: tendon displacement in, ticks on a serial bus out, with limits and reactions of their own."""
