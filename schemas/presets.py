"""Configurations by name, as TOML, for a start."""

PAPER = """\
# The simulation of Danesh & Janabi-Sharifi: forward Euler along the rod with 200 nodes, in controller and plant.
# Their target is x = 340 mm and z = 0, which no shape of the rod has; z = 39.8 mm is where it is at x = 340 mm
# when it is bent as far as theirs. With the default scheme the same parameters give z = 47.5 mm.

[rod]
space = "euler"
nodes = 200

[simulator.rod]
space = "euler"
nodes = 200

[reference]
kind = "exponential"
position = [0.34, 0.0, 0.0398]
path = "direct"
rate = 20.0
"""

WIRED = """\
# The paper's robot behind real drivers: displacements wound by servos at their real speed, elastic tendons, and motion
# capture at 100 Hz with 0.1 mm of noise that is 10 ms old when it arrives.

[rod]
tendon_stiffness = 20000.0

[limits]
tension_max = 60.0
displacement_min = -0.08
displacement_max = 0.08
displacement_rate = 0.08
slack = 0.001

[observer]
delay = 0.02
lag = 0.03

[reference]
kind = "minimum_jerk"
duration = 2.5

[simulator]
drive = "displacement"

[simulator.rod]
tendon_stiffness = 20000.0

[simulator.mocap]
noise = 1e-4
latency = 0.01
"""
WIRED_VICON = """\
address = "127.0.0.1"
base_axes = ["+z", "+x", "+y"]
latency = 0.01
"""
WIRED_SERVO = """\
answer_timeout = 0.05
watchdog = 0.5
command_timeout = 0.2
"""
