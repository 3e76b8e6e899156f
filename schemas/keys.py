"""Zenoh key expressions: all start with the rig's name."""

import re

CONFIG_VARIABLE = "ZENOH_CONFIG"
"""Environment variable that names a process's own Zenoh configuration: users, certificates, access."""

RIG_NAME = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")

TIP_POSE = "tip/pose"
TENDON_STATE = "tendon/state"
TENDON_COMMAND = "tendon/command"
STATUS = "status"
SIMULATOR_TRUTH = "sim/truth"
CONTROL = "control"
SENSOR = "sensor"
"""Sensors beside the pose, `sensor/<name>`."""
SERVO_RESET = "servo/reset"
SERVO_HEALTH = "servo/health"
SIMULATOR_INJECT = "sim/inject"
ALIVE = "controller"
"""Liveliness token of the controller; a second one has its identity, `controller/<identity>`."""


def key(rig: str, name: str) -> str:
    """Return `<rig>/<name>`.

    Raises:
        ValueError: the rig's name has characters that a key may not have.
    """
    if not RIG_NAME.fullmatch(rig):
        raise ValueError(f"rig name {rig!r}: use 1 to 32 of a-z, 0-9, '-' and '_', starting with a letter or digit")
    return f"{rig}/{name}"


def sensor_topic(name: str) -> str:
    """Return `sensor/<name>`."""
    return f"{SENSOR}/{name}"


def control_key(rig: str, action: str) -> str:
    """Return `<rig>/control/<action>`."""
    return key(rig, f"{CONTROL}/{action}")
