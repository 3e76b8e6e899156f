"""CiA 402 drives: tendon displacement in, target positions on a CAN bus out, under the servo driver's reactions."""
