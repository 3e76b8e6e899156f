"""An operator's requests to the controller: arm, stop, reset, status."""

import zenoh

from tendond.drivers.session import BusError, open_client
from tendond.schemas.config import RigConfig
from tendond.schemas.keys import control_key
from tendond.schemas.messages import ENCODING, ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode

ANSWER_SECONDS = 2.0


def ask(session: zenoh.Session, rig: str, action: ControlAction) -> ControlReply:
    """Put a request to the controller and wait for its answer.

    Raises:
        BusError: no answer, or one that cannot be read.
    """
    replies = session.get(
        control_key(rig, action.value),
        payload=encode(ControlRequest(action=action)),
        encoding=ENCODING,
        timeout=ANSWER_SECONDS,
    )
    for reply in replies:
        if reply.ok is not None:
            try:
                return decode(ControlReply, reply.ok.payload.to_bytes())
            except UnreadableError as error:
                raise BusError(f"the controller's answer is {error.reason}: are both of the same version?") from None
    raise BusError(
        f"no controller of rig '{rig}' answers within {ANSWER_SECONDS:g} s: is it still starting, or another rig?"
    )


def request(config: RigConfig, action: ControlAction, timeout: float = 1.0) -> ControlReply:
    """Connect, ask, disconnect.

    Raises:
        BusError: there is no controller, or no answer.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        return ask(session, config.rig.name, action)
