"""Requests of ROS 2 to the controller: each is carried out in time or refused, one after another, a stop at once."""

import queue
import threading
import time
from collections import Counter
from collections.abc import Callable

from tendond import TendondError
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

WAITING_MAX = 4
"""Requests that may wait for those before them."""

WAIT_SECONDS = 1.0
"""Longest time that a request may wait for those before it [s]: what is carried out later surprises."""

Done = Callable[[bool, str], None]
"""Takes whether a request was carried out, and the controller's words or the reason for a refusal."""


class Operator:
    """An operator on behalf of ROS 2.

    Args:
        ask: sends a request to the controller and waits for its reply, as `tendond arm` does (`bus.operator.ask`).

    Attributes:
        refused: number of refusals by what was asked for, and `last_refusal`, with its reason.
    """

    def __init__(self, ask: Callable[[ControlRequest], ControlReply]) -> None:
        self._ask = ask
        self.refused: Counter[str] = Counter()
        self.last_refusal = ""
        self._lock = threading.Lock()
        self._stops, self._others = (queue.Queue[tuple[ControlRequest, Done, float]](WAITING_MAX) for _ in range(2))
        for waiting in (self._stops, self._others):  # of the process: a plan may take longer than its end may
            threading.Thread(target=self._work, args=(waiting,), daemon=True).start()

    def submit(self, request: ControlRequest, done: Done) -> None:
        """Carry out a request as soon as those before it are; `done` is called in another thread.

        A stop waits for nothing but other stops.
        """
        waiting = self._stops if request.action is ControlAction.STOP else self._others
        try:
            waiting.put_nowait((request, done, time.monotonic()))
        except queue.Full:
            done(False, self.refuse(request.action.value, f"{WAITING_MAX} requests wait already: try again"))

    def refuse(self, what: str, reason: str) -> str:
        """Note a refusal, for the diagnostics; return the reason."""
        with self._lock:
            self.refused[what] += 1
            self.last_refusal = f"{what}: {reason}"
        return reason

    def _work(self, waiting: "queue.Queue[tuple[ControlRequest, Done, float]]") -> None:
        while True:
            request, done, since = waiting.get()
            action = request.action
            waited = time.monotonic() - since
            if waited > WAIT_SECONDS and action is not ControlAction.STOP:
                done(False, self.refuse(action.value, f"waited for {waited:.1f} s behind another request: try again"))
                continue
            try:
                reply = self._ask(request)
            except TendondError as error:
                done(False, self.refuse(action.value, str(error)))
                continue
            done(reply.done, reply.message if reply.done else self.refuse(action.value, reply.message))
