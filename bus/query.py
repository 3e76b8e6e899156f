"""Requests with a `ControlReply`: both ends of a Zenoh query."""

from collections.abc import Callable
from contextlib import suppress

import zenoh

from tendond.bus.client import BusError
from tendond.schemas.messages import ENCODING
from tendond.schemas.requests import ControlReply
from tendond.schemas.wire import UnreadableError, decode, encode

Queryable = zenoh.Queryable[zenoh.handlers.Handler[zenoh.Query]]


def replies(
    session: zenoh.Session, expression: str, payload: bytes | None, timeout: float, who: str
) -> list[ControlReply]:
    """Query a key and collect the replies of everyone who replies in time.

    Args:
        session: to ask with.
        expression: full key of the request.
        payload: payload of the request, JSON; none: the key says it all.
        timeout: to wait for replies [s].
        who: the replying process, for the message.

    Raises:
        BusError: a reply cannot be decoded.
    """
    found = []
    for reply in session.get(
        expression,
        payload=payload,
        encoding=ENCODING if payload is not None else None,
        timeout=timeout,
        target=zenoh.QueryTarget.ALL,
        consolidation=zenoh.ConsolidationMode.NONE,
    ):
        if reply.ok is not None:
            try:
                found.append(decode(ControlReply, reply.ok.payload.to_bytes()))
            except UnreadableError as error:
                raise BusError(f"the {who}'s reply is {error.reason}: are both of the same version?") from None
    return found


def reply_to_next(queryable: Queryable, reply_to: Callable[[bytes | None], ControlReply]) -> None:
    """Reply to the next query, if there is one; never waits.

    Args:
        queryable: with the queries that have arrived.
        reply_to: makes the reply from a query's payload.
    """
    if (query := queryable.try_recv()) is None:
        return
    reply = reply_to(None if query.payload is None else query.payload.to_bytes())
    with suppress(zenoh.ZError):  # the asking process may have exited
        query.reply(query.key_expr, encode(reply), encoding=ENCODING)
    query.drop()
