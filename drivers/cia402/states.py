"""State machine of a CiA 402 drive, as its driver sees it. Reads no clock.

Statuswords and controlwords are those of CiA 402-2, "Controlling the power drive system".
"""

from enum import StrEnum

FAULT_BIT = 1 << 3
FOLLOWING_ERROR_BIT = 1 << 13
"""Of the statusword, in cyclic synchronous position mode."""

DISABLE_VOLTAGE = 0x0000
SHUTDOWN = 0x0006
SWITCH_ON = 0x0007
ENABLE_OPERATION = 0x000F
FAULT_RESET = 0x0080


class DriveState(StrEnum):
    """State of a drive, with the name of the standard."""

    NOT_READY = "not ready to switch on"
    DISABLED = "switch on disabled"
    READY = "ready to switch on"
    SWITCHED_ON = "switched on"
    ENABLED = "operation enabled"
    QUICK_STOP = "quick stop active"
    REACTING = "fault reaction active"
    FAULT = "fault"


STATES = (
    (0x4F, 0x00, DriveState.NOT_READY),
    (0x4F, 0x40, DriveState.DISABLED),
    (0x6F, 0x21, DriveState.READY),
    (0x6F, 0x23, DriveState.SWITCHED_ON),
    (0x6F, 0x27, DriveState.ENABLED),
    (0x6F, 0x07, DriveState.QUICK_STOP),
    (0x4F, 0x0F, DriveState.REACTING),
    (0x4F, 0x08, DriveState.FAULT),
)
"""Mask and value of the statusword, of each state."""

POWERED = (DriveState.ENABLED, DriveState.QUICK_STOP, DriveState.REACTING)
"""States in which the motor has torque."""


def state_of(statusword: int) -> DriveState:
    """Return the state; a statusword of none counts as not ready."""
    for mask, value, state in STATES:
        if statusword & mask == value:
            return state
    return DriveState.NOT_READY


def towards_enabled(state: DriveState) -> int:
    """Return the controlword that leads one step towards operation enabled; a fault is left to its reset."""
    if state is DriveState.READY:
        return SWITCH_ON
    if state in (DriveState.SWITCHED_ON, DriveState.ENABLED):
        return ENABLE_OPERATION
    return SHUTDOWN if state is DriveState.DISABLED else DISABLE_VOLTAGE
