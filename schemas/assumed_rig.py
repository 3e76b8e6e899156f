"""Assumptions about servos, tendons and camera of the paper's robot, which the paper does not specify."""

TENDON_STIFFNESS = 2e4
"""Stiffness of half a metre of Kevlar cord [N/m], where tendons are elastic."""

SERVO_RATE = 0.085
"""Speed of a tendon [m/s]: an XL430 on a spool of 15 mm radius reaches 0.09 m/s without load."""

RESOLUTION = 2.3e-5
"""Displacement of one of 4096 ticks a turn, on a spool of 15 mm radius [m]."""

BACKLASH = 6.5e-5
"""Play of a servo's gears, as a displacement [m]."""

POSE_NOISE = 1e-4
"""Standard deviation of each coordinate of a pose [m]."""

POSE_DELAY = 0.01
"""Age of a pose when it arrives [s]."""
