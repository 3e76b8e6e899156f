"""The drive in the loop: servos, tendons and delays between command and tip, cause by cause, in lockstep."""
