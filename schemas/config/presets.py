"""Configurations by name, as TOML: profiles of the simulator, and sections of the wired rig."""

from tendond.schemas.assumed_rig import (
    BACKLASH,
    COMMAND_DELAY,
    FRICTION,
    POSE_DELAY,
    POSE_NOISE,
    RESOLUTION,
    SERVO_ACCELERATION,
    SERVO_LAG,
    SERVO_RATE,
    TENDON_STIFFNESS,
    WIRED_DELAY,
)
from tendond.schemas.paper_robot import TARGET_X

PAPER = f"""\
# The simulation of Danesh & Janabi-Sharifi: forward Euler along the rod with 200 nodes, in controller and plant.
# Their target is x = 340 mm and z = 0, which no shape of the rod has; z = 39.8 mm is where it is at x = 340 mm
# when it is bent as much as theirs. With the default scheme the same parameters give z = 47.5 mm.

[rod]
space = "euler"
nodes = 200

[simulator.rod]
space = "euler"
nodes = 200

[limits]
tension_rate = 6000.0  # in effect no limit, as in the paper
displacement_rate = 5.0

[control]
sampled = false  # the laws as published

[commissioning]
probe = false  # the experiment begins at arming

[reference]
kind = "exponential"
position = [{TARGET_X}, 0.0, 0.0398]
path = "direct"
rate = 20.0
"""

_SERVOS = """\
# The paper's robot with real hardware: XL430 servos, elastic tendons on spools of 15 mm, and motion capture at 100 Hz
# with noise and 10 ms of delay. 57 rpm give 90 mm/s without load; 85 mm/s are assumed, with the servos' profile
# acceleration of 200 rad/s^2. The smallest step is one of 4096 ticks. Lag and backlash of the servos, friction and
# stiffness of the tendons are assumptions. The paper's reference is too fast for these servos: this one takes longer.

[rod]
tendon_stiffness = {stiffness}

[limits]
tension_max = 60.0
displacement_min = -0.08
displacement_max = 0.08
displacement_rate = {rate}
slack = 0.001

[observer]
{observer}

[reference]
kind = "minimum_jerk"
duration = {duration}

[simulator]
drive = "displacement"

[simulator.servo]
rate = {servo_rate}
acceleration = {acceleration}
lag = {lag}
backlash = {backlash}
friction = {friction}
resolution = {resolution}

[simulator.rod]
tendon_stiffness = {stiffness}
{rod}
[simulator.mocap]
noise = {noise}
latency = {latency}
{mocap}"""


def _observer(command_delay: float) -> str:
    """Write the keys of [observer] that describe the camera and the servos."""
    return (
        f"delay = {POSE_DELAY}\ncommand_delay = {command_delay}\n"
        f"servo_acceleration = {SERVO_ACCELERATION}\nbacklash = {BACKLASH}"
    )


def _servos(**different: object) -> str:
    """Write the configuration of the rig with servos, with some of its numbers and lines replaced."""
    assumed: dict[str, object] = {
        "rate": SERVO_RATE, "servo_rate": SERVO_RATE, "stiffness": TENDON_STIFFNESS, "resolution": RESOLUTION,
        "backlash": BACKLASH, "noise": POSE_NOISE, "latency": POSE_DELAY, "duration": 2.0,
        "acceleration": SERVO_ACCELERATION, "lag": SERVO_LAG, "friction": FRICTION,
        "observer": _observer(COMMAND_DELAY), "rod": "", "mocap": "",
    }  # fmt: skip
    return _SERVOS.format(**assumed | different)


RIG = _servos()

WIRED = _servos(rate=0.08, duration=2.5, friction=0.1, observer=_observer(WIRED_DELAY) + "\nstamps = true")
"""RIG behind the real drivers, whose dead time is longer; the reference is slower, and friction half, so that the load
of the servos stays well below the one that is a fault."""

NASTY = _servos(
    backlash=3e-4,
    observer=f"delay = {POSE_DELAY}",  # it knows nothing of the servos, nor of what follows
    friction=0.1,
    rod="youngs_modulus = 171e9  # -10 %\nbending_damping = [0.0056, 0.0056, 0.0056]  # times 0.7\n",
    noise=3e-4,
    mocap="""\
jitter = 0.005
dropout = 0.05
occlusion = 1.0
occlusion_time = 0.03

[simulator.weight]
mass = 0.02

[[simulator.impacts]]
time = 6.0
duration = 0.05
force = [2.0, 0.0, 0.0]

[[simulator.impacts]]
time = 8.0
duration = 0.05
force = [0.0, 0.0, -3.0]
place = 0.6
""",
)

SPACE = """\
# A circle of the tip about the straight rod, with all four tendons.

[control]
law = "sensitivity"

[reference]
kind = "circle"
radius = 0.25
period = 4.0
laps = 3
"""

WIRED_SPACE = SPACE.partition("[reference]")[0] + WIRED.replace(
    'kind = "minimum_jerk"', SPACE.partition("[reference]\n")[2].rstrip()
).replace("[rod]\n", "[rod]\ntendon_friction = 0.1\n", 1)
"""SPACE behind servos, which are too slow for it: the reference is slowed down to their rate. Friction is configured:
on a moving path the observer is too slow for what it does."""

PROFILES = {"paper": PAPER, "rig": RIG, "nasty": NASTY}
"""Profiles by their name for `--profile`."""

WIRED_VICON = """\
address = "127.0.0.1"
base_axes = ["+z", "+x", "+y"]
latency = 0.01
"""
WIRED_SERVO = """\
# Emulated servos share a process with the simulated rod: on a busy machine they reply late.
reply_timeout = 0.5
silent_reads = 6
watchdog = 1.5
command_timeout = 0.5
following_time = 1.0
"""
