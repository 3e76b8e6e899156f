"""Servos of a rig under a stream of commands: the cycle and its phases, faults and their reset."""
