"""Modes as sentences, and the commands that clear a fault, named wherever a fault is shown."""

from tendond.schemas.messages import Mode

SENTENCES = {
    Mode.STARTING: "the controller is starting",
    Mode.IDLE: "the rig is idle",
    Mode.PROBE: "the tendons are being probed",
    Mode.PRETENSION: "the tendons are being pretensioned",
    Mode.TRACKING: "the arm is tracking",
    Mode.RELEASING: "the tendons are being released",
    Mode.FAULT: "the rig is in fault",
}

OF_THE_SERVOS = "tendons: "
"""Beginning of the reason of a fault that the tendons' driver has reported."""


def clearing(reason: str, option: str = "", *, has_servos: bool = False) -> str:
    """Name the commands that clear a controller's fault: "fix the cause, then 'tendond reset'".

    Args:
        reason: of the fault, as in the status.
        option: that names the rig, such as " --config rig.toml".
        has_servos: the rig has a servo driver, which keeps its own fault until it is reset.
    """
    own = f"'tendond servo reset{option}' and " if has_servos and reason.startswith(OF_THE_SERVOS) else ""
    return f"fix the cause, then {own}'tendond reset{option}'"


def sentence(message: str, mode: Mode, to_clear: str, option: str = "") -> str:
    """Turn a controller's short reply into a sentence with the command that helps.

    The reply is in the log, whose replay compares it to the letter, so the words are added where it is shown.

    Args:
        message: reply to a request, such as "not armed: already probe".
        mode: of the controller afterwards.
        to_clear: how its fault is cleared, see `clearing`; empty without a fault.
        option: that names the rig.
    """
    stop = f"'tendond stop{option}'"
    if mode is Mode.FAULT:
        head = message.removesuffix("; reset first")
        return f"{head}: {to_clear}" if head != message or message.startswith("in fault") else message
    for end, words in (
        (f"already {mode.value}", _already(mode, stop)),
        (f"{mode.value}; stop first", f"{SENTENCES[mode]}; run {stop} first"),
        (f": {mode.value}", f": {SENTENCES[mode]}"),
    ):
        if message.endswith(end):
            return message.removesuffix(end) + words
    return message


def _already(mode: Mode, stop: str) -> str:
    by_itself = mode in (Mode.STARTING, Mode.RELEASING)
    return f"{SENTENCES[mode]}; {'arm again once the rig is idle' if by_itself else f'{stop} ends it'}"
