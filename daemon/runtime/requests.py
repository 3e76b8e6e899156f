"""Operators' requests as they come in: a ring for each action, those that change the mode first, questions bounded.

A flood of questions fills the ring of the questions only, so a stop is always heard. A request that has waited so long
that its sender may have given up is refused and never carried out; a stop is carried out all the same.
"""

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import zenoh

from tendond.schemas.keys import CONTROL, key
from tendond.schemas.messages import ENCODING
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode

QUEUE = 64
"""Requests of an action that are kept between two cycles; older ones are dropped without notice."""

PER_CYCLE = 16
"""Requests of an action that are read in a cycle."""

QUESTIONS_PER_SECOND = 1000.0
"""Largest rate of status queries that get a reply [1/s]: 50 us each, a twentieth of the loop's time."""

WAITING = 16
"""Requests that may wait for a cycle of their own; further ones are refused."""

PATIENCE_SECONDS = 0.5
"""Age from which on a request without a deadline counts as one that its sender has given up."""

CATCH_UP_SECONDS = 1.0
"""Time after a standstill for the bus to deliver what has waited in its sockets [s]."""

ORDER = (
    ControlAction.RESET,
    ControlAction.ARM,
    ControlAction.PROBE,
    ControlAction.LAW,
    ControlAction.REFERENCE,
    ControlAction.SET,
    ControlAction.JOG,
)
"""Order of the requests that wait for a cycle each; a stop comes before all of them."""

Queryable = zenoh.Queryable[zenoh.handlers.Handler[zenoh.Query]]


@dataclass(frozen=True)
class Question:
    """An operator's request that waits for its reply.

    Attributes:
        request: request as it came.
        query: the Zenoh query to reply to.
        after: the moment before which it had not come [s], on the monotonic clock.
    """

    request: ControlRequest
    query: zenoh.Query
    after: float

    def reply(self, reply: ControlReply) -> None:
        """Send the reply; an operator who has gone away meanwhile is not missed."""
        send_reply(self.query, reply)

    def refuse(self, reason: str) -> None:
        """Reply that it is not done, and why."""
        self.reply(ControlReply(done=False, message=reason))


class Requests:
    """The requests of a rig's operators.

    Args:
        session: open.
        rig: its name.
        source: identity of this controller.
        period: period of the cycle [s].
    """

    def __init__(self, session: zenoh.Session, rig: str, source: str, period: float) -> None:
        self._source = source
        self._questions = max(1, min(PER_CYCLE, round(QUESTIONS_PER_SECOND * period)))
        self._rings: dict[ControlAction, Queryable] = {
            action: session.declare_queryable(
                key(rig, f"{CONTROL}/{action.value}"), zenoh.handlers.RingChannel(QUEUE), complete=True
            )
            for action in ControlAction
        }
        self._waiting: dict[ControlAction, deque[Question]] = {action: deque() for action in ORDER}
        self._read = dict.fromkeys(ControlAction, 0.0)  # the moment at which a ring was empty [s]
        self._received = 0.0
        self._caught_up = 0.0  # until then, what comes in may have waited in a socket while this process stood still
        self.stops: list[Question] = []
        self.questions: list[Question] = []

    def receive(self, now: float) -> None:
        """Read what has come in: into `stops`, `questions` (of the status), and what `next` gives.

        Args:
            now: monotonic time [s].
        """
        if now - self._received > PATIENCE_SECONDS:
            self._caught_up = now + CATCH_UP_SECONDS
        self._received = now
        self.stops = self._ring(ControlAction.STOP, now)
        self.questions = self._ring(ControlAction.STATUS, now, self._questions)
        for action, waiting in self._waiting.items():
            for question in self._ring(action, now):
                if len(waiting) < WAITING:
                    waiting.append(question)
                else:
                    question.refuse(f"too many requests to {action.value} are waiting: ask again")

    def refuse_waiting(self, reason: str, actions: tuple[ControlAction, ...] = ORDER) -> None:
        """Refuse every request that waits, whatever it asks for."""
        for action in actions:
            while self._waiting[action]:
                self._waiting[action].popleft().refuse(reason)

    def refuse_all(self, reason: str, now: float) -> None:
        """Refuse every request that waits or has come in, but for stops and questions of the status."""
        self.refuse_waiting(reason)
        for action in ORDER:
            for question in self._ring(action, now, QUEUE):
                question.refuse(reason)

    def next(self, now: float, refusal: Callable[[ControlRequest], str] = lambda request: "") -> Question | None:
        """The next request for a cycle, by rank; those that came too late are refused.

        Args:
            now: monotonic time [s].
            refusal: why a request cannot be carried out now, in words; empty if it can.
        """
        for action in ORDER:
            waiting = self._waiting[action]
            while waiting:
                question = waiting.popleft()
                if reason := self.too_late(question, now) or refusal(question.request):
                    question.refuse(reason)
                else:
                    return question
        return None

    def too_late(self, question: Question, now: float) -> str:
        """Say why a request must not be carried out any more; empty if it may be."""
        request, waited = question.request, now - question.after
        if request.controller and request.controller != self._source:
            return f"not done: it was meant for the controller '{request.controller}', which is gone"
        if request.deadline_ns is not None:
            return "not done: it came too late, its sender had given up" if now * 1e9 > request.deadline_ns else ""
        if waited > PATIENCE_SECONDS or question.after < self._caught_up:
            return "not done: the controller stood still meanwhile, and its sender may have given up; ask again"
        return ""

    def _ring(self, action: ControlAction, now: float, limit: int = PER_CYCLE) -> list[Question]:
        """Readable requests of an action, oldest first; an unreadable one gets its reply here."""
        found, after = [], self._read[action]
        for _ in range(limit):
            if (query := self._rings[action].try_recv()) is None:
                self._read[action] = now
                break
            payload = b"" if query.payload is None else query.payload.to_bytes()
            try:
                request = decode(ControlRequest, payload)
            except UnreadableError as error:
                send_reply(query, ControlReply(done=False, message=f"the request is {error.reason} ({error.detail})"))
                continue
            if request.action is action:
                found.append(Question(request, query, after))
            else:
                send_reply(query, ControlReply(done=False, message="the request does not fit its key"))
        return found


def send_reply(query: zenoh.Query, reply: ControlReply) -> None:
    """Reply to a query; an operator who has gone away meanwhile is not missed."""
    with suppress(zenoh.ZError):
        query.reply(query.key_expr, encode(reply), encoding=ENCODING)
    query.drop()
