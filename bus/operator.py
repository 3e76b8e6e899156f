"""An operator's requests to the controller: arm, stop, reset, status, another law or reference."""

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.query import replies
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import control_key
from tendond.schemas.messages import Status
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import encode

REPLY_SECONDS = 2.0
PLAN_SECONDS = 90.0
"""Timeout of a new reference, which has to be planned [s]."""

MARGIN_SECONDS = 0.2
"""Time before the timeout at which the controller no longer begins a request, for the reply to arrive [s]."""


def ask(session: zenoh.Session, rig: str, asked: ControlAction | ControlRequest) -> ControlReply:
    """Send a request to the controller and wait for its reply.

    A request that changes anything is addressed to the one controller that replied to a status request, and has a
    deadline on that controller's clock: what is reported as failed here is not carried out later. The clock is read
    from the status, which was written before it arrived, so the deadline is never later than the timeout here. A stop
    goes to all controllers at once.

    Args:
        session: to the controller.
        rig: its name.
        asked: the request, or its action alone.

    Raises:
        BusError: no reply, or an unreadable one; or two controllers reply.
    """
    wanted = asked if isinstance(asked, ControlRequest) else ControlRequest(action=asked)
    if wanted.action is ControlAction.STOP:
        found = _replies(session, rig, wanted, REPLY_SECONDS)
        done = all(reply.done for reply in found)
        message = "; ".join(dict.fromkeys(reply.message for reply in found))
        if len(found) > 1:
            message = f"{len(found)} controllers reply: {message}"
        return ControlReply(done=done, message=message, status=found[0].status)
    question = ControlRequest(action=ControlAction.STATUS)
    found = _replies(session, rig, question, REPLY_SECONDS)
    if len(found) > 1:
        names = " and ".join(f"'{reply.status.source}'" for reply in found if reply.status is not None)
        raise BusError(f"{len(found)} controllers of rig '{rig}' reply: {names}; stop all but one")
    if wanted.action is ControlAction.STATUS:
        return found[0]
    patience = PLAN_SECONDS if wanted.action is ControlAction.REFERENCE else REPLY_SECONDS
    return _replies(session, rig, _addressed(wanted, found[0].status, patience), patience)[0]


def _addressed(wanted: ControlRequest, status: Status | None, patience: float) -> ControlRequest:
    """Add a deadline and the address of the controller with that status."""
    if status is None:
        return wanted
    deadline = status.stamp_ns + round((patience - MARGIN_SECONDS) * 1e9)
    return wanted.model_copy(update={"controller": status.source, "deadline_ns": deadline})


def _replies(session: zenoh.Session, rig: str, wanted: ControlRequest, timeout: float) -> list[ControlReply]:
    """Return the replies of all controllers of the rig; at least one.

    Raises:
        BusError: there is none, or one cannot be decoded.
    """
    found = replies(session, control_key(rig, wanted.action.value), encode(wanted), timeout, "controller")
    if not found:
        raise BusError(
            f"no controller of rig '{rig}' replies within {timeout:g} s: is it still starting, or another rig?"
        )
    return found


def status_in(reply: ControlReply) -> Status:
    """Return the status of a reply.

    Raises:
        BusError: it has none.
    """
    if reply.status is None:
        raise BusError(f"the controller gave no status: {reply.message}")
    return reply.status


def ask_status(session: zenoh.Session, rig: str) -> Status:
    """Ask the controller for its status.

    Raises:
        BusError: no reply, or one without a status; or two controllers reply.
    """
    return status_in(ask(session, rig, ControlAction.STATUS))


def request(config: RigConfig, asked: ControlAction | ControlRequest, timeout: float = 1.0) -> ControlReply:
    """Connect, send a request, disconnect.

    Raises:
        BusError: there is no controller, or no reply.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        return ask(session, config.rig.name, asked)
