"""An operator's requests to the controller: arm, stop, reset, status, another law or reference."""

import zenoh

from tendond.drivers.session import BusError, open_client
from tendond.schemas.config import RigConfig
from tendond.schemas.keys import control_key
from tendond.schemas.messages import ENCODING, ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode

ANSWER_SECONDS = 2.0


def ask(session: zenoh.Session, rig: str, asked: ControlAction | ControlRequest) -> ControlReply:
    """Put a request to the controller and wait for its answer.

    Args:
        session: to the controller.
        rig: its name.
        asked: the request, or its action where that says it all.

    Raises:
        BusError: no answer, or one that cannot be read.
    """
    wanted = asked if isinstance(asked, ControlRequest) else ControlRequest(action=asked)
    replies = session.get(
        control_key(rig, wanted.action.value),
        payload=encode(wanted),
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


def request(config: RigConfig, asked: ControlAction | ControlRequest, timeout: float = 1.0) -> ControlReply:
    """Connect, ask, disconnect.

    Raises:
        BusError: there is no controller, or no answer.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        return ask(session, config.rig.name, asked)
