"""Assumptions about servos, tendons and camera of the paper's robot, which the paper does not specify."""

TENDON_STIFFNESS = 2e4
"""Stiffness of half a metre of Kevlar cord [N/m], where tendons are elastic."""

SERVO_RATE = 0.085
"""Speed of a tendon [m/s]: an XL430 on a spool of 15 mm radius reaches 0.09 m/s without load."""

RESOLUTION = 2.3e-5
"""Displacement of one of 4096 ticks a turn, on a spool of 15 mm radius [m]."""

BACKLASH = 6.5e-5
"""Play of a servo's gears, as a displacement [m]."""

SERVO_ACCELERATION = 3.0
"""Acceleration of a tendon [m/s^2]: the servos' profile acceleration of 200 rad/s^2 on a spool of 15 mm radius."""

SERVO_LAG = 0.02
"""Time constant of a servo's position loop and gears, behind its profile [s]."""

FRICTION = 0.2
"""Coefficient of friction of the tendons on the disks [-]: Kevlar on polymer disks, 0.1 to 0.3."""

COMMAND_DELAY = 0.018
"""Dead time that stands for a servo's lag in lockstep [s]: of 14 to 22 ms the one with the smallest error on circles of
2 and 4 s (`tendond study servo`)."""

WIRED_DELAY = 0.024
"""The same through the drivers [s]: the controller's work and the two buses are added."""

POSE_NOISE = 1e-4
"""Standard deviation of each coordinate of a pose [m]."""

POSE_DELAY = 0.01
"""Age of a pose when it arrives [s]."""
