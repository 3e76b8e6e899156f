"""The queue of requests: which request goes into the coming cycle, what is planned meanwhile, who gets which reply."""

from collections.abc import Callable

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.runtime.planner import Planner
from tendond.daemon.runtime.requests import Question, Requests
from tendond.schemas.messages import Mode, Status
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

STARTING = "not done: the controller was still starting; ask again"
PLANNING = "a reference is being planned: wait for it, or stop to give it up"


class RequestQueue:
    """Requests waiting for the cycle, and their replies.

    A stop is heard first, whatever else waits; every stop that waits gets its reply at once, a request to arm that came
    with it is refused. A reference is planned by another process, and goes into a cycle when the plan is there.

    Args:
        setup: setup of the cycle; plans are put into it.
        requests: requests as they come in.
        planner: none: references are planned in the cycle, as offline.
    """

    def __init__(self, setup: CycleSetup, requests: Requests, planner: Planner | None = None) -> None:
        self._setup = setup
        self._requests = requests
        self._planner = planner
        self._planned: Question | None = None  # the one whose reference is being planned
        self._asked: list[Question] = []  # of this cycle

    def open(self, now: float) -> None:
        """Refuse what has waited since before the loop runs: its senders may have concluded that nobody replies."""
        self._requests.refuse_all(STARTING, now)

    def take(
        self, now: float, state: CycleState, own: ControlAction | None
    ) -> tuple[ControlAction | None, ControlRequest | None]:
        """The request of the coming cycle, and its words if it is an operator's.

        Args:
            now: monotonic time [s].
            state: before the cycle.
            own: the loop's own request.
        """
        self._requests.receive(now)
        self._asked = []
        if self._requests.stops:
            self._asked = self._requests.stops
            self._requests.refuse_waiting("not armed: a stop came with it", (ControlAction.ARM, ControlAction.PROBE))
            self._give_up_plan("not changed: stopped while it was planned")
            return ControlAction.STOP, None
        if own is not None:
            return own, None
        if (question := self._with_plan(now)) is None:
            question = self._requests.next(now, self._refusal)
        if question is None:
            return None, None
        idle = state.mode is Mode.IDLE
        wanted = question.request
        if wanted.reference is not None and idle and self._planner is not None and question is not self._planned:
            self._give_up_plan("not changed: another reference was asked for meanwhile")
            self._planned = question
            self._planner.plan(state.selection.law_name, wanted.reference)
            return None, None
        if question is self._planned:
            self._planned = None
        self._asked = [question]
        return wanted.action, wanted

    def fail(self, error: Exception) -> None:
        """Reply to the cycle's request, which the cycle could not take, with the reason."""
        for question in self._asked:
            question.refuse(f"not done: {type(error).__name__}: {error}")
        self._asked = []

    def reply(self, record: CycleRecord, status: Callable[[], Status]) -> None:
        """Reply to what the cycle has carried out or refused, and to the questions of the status."""
        questions = self._requests.questions
        if not (self._asked or questions):
            return
        now = status()
        for question in self._asked:
            question.reply(ControlReply(done=record.accepted, message=record.reply, status=now))
        for question in questions:
            question.reply(ControlReply(done=True, message=record.mode.value, status=now))
        self._asked = []

    def _refusal(self, request: ControlRequest) -> str:
        if self._planned is None:
            return ""
        refused = {
            ControlAction.ARM: "not armed",
            ControlAction.PROBE: "not probed",
            ControlAction.LAW: "not changed",
        }.get(request.action)
        return f"{refused}: {PLANNING}" if refused else ""

    def _with_plan(self, now: float) -> Question | None:
        """The question whose plan has come, once it has; one without a plan, or too late, gets its reply here."""
        plan = None if self._planner is None else self._planner.poll()
        question = self._planned
        if plan is None or question is None:
            return None
        if reason := self._requests.too_late(question, now) or (plan.error and f"not changed: {plan.error}"):
            question.refuse(reason)
            self._planned = None
            return None
        assert plan.reference is not None
        self._setup.plans.keep(plan.law, plan.section, plan.reference)
        return question

    def _give_up_plan(self, reason: str) -> None:
        if self._planned is not None and self._planner is not None:
            self._planned.refuse(reason)
            self._planner.give_up()
            self._planned = None
