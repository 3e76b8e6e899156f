"""The Cosserat rod model of the robot: pure numerics, no I/O, no clock, no knowledge of control or Zenoh."""
