"""The loop: the only clock. It wakes, lets `cycle.respond` decide, publishes, and hands the record to the recorder."""

import gc
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from functools import partial

from tendond.bus.systemd import Supervisor
from tendond.daemon.control.cycle import respond
from tendond.daemon.control.phases.modes import ACTIVE, is_taut
from tendond.daemon.control.record import Response, write_record
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, followed_sources
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.emergency import RELEASE_SECONDS, next_seq, release_at_once, slack_command
from tendond.daemon.runtime.health import Health
from tendond.daemon.runtime.pacing import Pacer
from tendond.daemon.runtime.planner import Planner
from tendond.daemon.runtime.plant_check import PlantCheck
from tendond.daemon.runtime.request_queue import RequestQueue
from tendond.daemon.runtime.status import status_of
from tendond.daemon.runtime.warm_up import warm_up
from tendond.schemas.messages import Mode, Status, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord, LoopTiming
from tendond.schemas.requests import ControlAction, ControlRequest
from tendond.schemas.wire import decode, encode

STATUS_SECONDS = 1.0

COLLECT_EVERY = 100
"""Cycles between two collections of the youngest garbage."""


class Loop:
    """The controller's loop over a hub.

    Args:
        setup: setup of the cycle.
        hub: open.
        run_log: destination of the records.
        arm_at: tick at which the loop arms by itself; for lockstep simulation only, so that runs repeat exactly.
        planner: planner of references; without one they are planned in the cycle.
        supervisor: is notified of changes of mode, of the end, and by each cycle done in time that the loop is alive.
        say: prints a line for people, from another thread than the loop's.
    """

    def __init__(
        self,
        setup: CycleSetup,
        hub: Hub,
        run_log: RunLog,
        arm_at: int | None = None,
        supervisor: Supervisor | None = None,
        planner: Planner | None = None,
        say: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._setup = setup
        self._hub = hub
        self._run_log = run_log
        self._arm_at = arm_at
        self._supervisor = supervisor or Supervisor({})
        self._request_queue = RequestQueue(setup, hub.requests, planner)
        self._health = Health()
        self._plant_check = PlantCheck(setup.config.rod, run_log.warning, say)
        self._status_seq = 0
        self._malformed_said = False
        self._second_source = False  # two publishers of a key, or two controllers
        self._speculated: tuple[int, Response] | None = None  # to how many inputs

    def warm(self) -> CycleState:
        """The initial state, after a few cycles of warm-up: every kernel is loaded, or compiled if it has to be."""
        return warm_up(self._setup)

    def run(self, state: CycleState, pacer: Pacer, stopped: Callable[[], bool], cycles: int | None = None) -> None:
        """Run until stopped and released, or for so many cycles; whatever ends it, a slack command goes out last.

        Args:
            state: to begin with.
            pacer: what a cycle waits for.
            stopped: true when the process is to end: the tendons are released first.
            cycles: to run; none: no end.

        Raises:
            DaemonError: a cycle failed unexpectedly; the tendons have been released, and the log says why.
        """
        gc.collect()
        gc.freeze()
        gc.disable()
        self._state = state
        self.speculate(Arrivals())  # the first one is slow
        self._speculated = None
        self._run_log.state(state)
        try:
            self._run(pacer, stopped, cycles)
        except Exception as error:
            self._supervisor.stopping()
            self._run_log.crash(traceback.format_exc())
            release_at_once(self._setup.config, self._hub)
            raise DaemonError(f"the controller failed: {type(error).__name__}: {error}; see its log") from error
        finally:
            gc.enable()
            self._supervisor.stopping()
            self._hub.publish_last(slack_command(self._setup.rod.parameters.tendon_count, next_seq(self._hub)))

    def speculate(self, arrivals: Arrivals) -> None:
        """The coming cycle on what has arrived so far: if nothing else comes, its command is ready at the deadline.

        `respond` is a pure function, so a response to the same inputs is the same response. If something comes, that
        cycle finds its code and data in the processor's caches, from which other processes push them while the loop
        sleeps. Before the pose has come, the last one stands in for it, and the response is discarded.
        """
        pose = self._state.pose
        with suppress(Exception):  # what is wrong will show in the cycle itself, where it is dealt with
            if arrivals.pose is not None or pose is None:
                self._speculated = (arrivals.inputs, respond(self._setup, self._state, _inputs(arrivals)))
            else:
                pose = decode(TipPose, encode(pose.model_copy(update={"seq": pose.seq + 1})))
                encode(respond(self._setup, self._state, CycleInputs(pose=pose)).command.stamped(time.monotonic_ns()))

    def _run(self, pacer: Pacer, stopped: Callable[[], bool], cycles: int | None) -> None:
        published: object = None  # the last status, for its changes
        next_status = 0.0
        give_up: float | None = None
        self._request_queue.open(time.monotonic())
        while cycles is None or self._health.cycles < cycles:
            stopping = stopped()
            if stopping:
                self._supervisor.stopping()
                give_up = give_up or time.monotonic() + RELEASE_SECONDS
                if not _holding(self._state) or time.monotonic() > give_up:
                    break
            wake = pacer.wait()
            if wake is None:
                break
            own = None
            if stopping and self._state.mode in ACTIVE:
                own = ControlAction.STOP
            elif self._state.tick == self._arm_at:
                own = ControlAction.ARM
            requested, request = self._request_queue.take(time.monotonic(), self._state, own)
            response = None
            if requested is None and not wake.missed_ticks:
                response = self._ready(wake.arrivals)
            ahead = response is not None
            if response is None:
                response = self._respond(_inputs(wake.arrivals, requested, request, wake.missed_ticks))
            self._state, self._speculated = response.state, None
            self._hub.followed = followed_sources(self._state)
            self._hub.publish_command(response.command.stamped(time.monotonic_ns()))
            work_us = (time.monotonic() - wake.at) * 1e6
            # The command is out: all else can wait.
            self._health.add(work_us, wake.missed_ticks, wake.pose_wait, phase_locked=wake.locked)
            if not wake.missed_ticks and wake.lateness + work_us * 1e-6 <= self._setup.config.loop.period:
                self._supervisor.alive()  # a log that has ended is no reason to be killed: control goes on without it
            record = write_record(self._setup, response)
            self._request_queue.reply(record, partial(self._status, record))
            timing = LoopTiming.trusted(
                tick=record.tick,
                lateness_us=wake.lateness * 1e6,
                work_us=work_us,
                missed_ticks=wake.missed_ticks,
                ahead=ahead,
                speculation_us=wake.speculation * 1e6,
                pose_wait_us=None if wake.pose_wait is None else wake.pose_wait * 1e6,
                phase_locked=wake.locked,
            )
            truth = self._plant_check.without_rod(wake.arrivals.decoded_truth())
            self._run_log.cycle(record, timing, self._state.rod, truth)
            self._run_log.state(self._state)
            if self._state.unreadable and not self._malformed_said:
                self._malformed_said = True
                self._run_log.warning(f"malformed: {self._state.unreadable}")
            second_source = self._state.sources.in_words()
            if second_source and not self._second_source:
                self._run_log.warning(second_source)
            self._second_source = bool(second_source)
            now = (record.mode, record.law, record.reference.target, self._run_log.error, second_source)
            if now != published or time.monotonic() >= next_status:
                status = self._status(record)
                self._hub.publish_status(status)
                self._run_log.status(status, changed=now != published)
                if now != published:
                    self._supervisor.status(
                        "; ".join(filter(None, (_in_words(record), second_source, self._run_log.error)))
                    )
                published, next_status = now, time.monotonic() + STATUS_SECONDS
            if record.tick % COLLECT_EVERY == 0:
                gc.collect(0)

    def _respond(self, inputs: CycleInputs) -> Response:
        """The cycle on its inputs; a request that it cannot take gets the reason as its reply and is left out."""
        try:
            return respond(self._setup, self._state, inputs)
        except Exception as error:
            if inputs.request is None:
                raise
            self._request_queue.fail(error)
            self._run_log.warning(f"the request '{inputs.request.value}' failed: {traceback.format_exc()}")
            without: dict[str, object] = {"request": None, "law": None, "reference": None, "settings": {}, "jog": None}
            return respond(self._setup, self._state, inputs.model_copy(update=without))

    def _ready(self, arrivals: Arrivals) -> Response | None:
        """The speculation's response, if nothing has come in since."""
        if self._speculated is None:
            return None
        inputs, response = self._speculated
        return response if inputs == arrivals.inputs else None

    def _status(self, record: CycleRecord) -> Status:
        self._status_seq += 1
        health = self._health.report(self._run_log.dropped, self._run_log.error, self._run_log.days_left)
        return status_of(self._setup, self._state, record, self._status_seq, health)


def _inputs(
    arrivals: Arrivals, action: ControlAction | None = None, request: ControlRequest | None = None, missed: int = 0
) -> CycleInputs:
    """Return the inputs of a cycle: what has arrived, and a request, in the operator's words if it is one's."""
    return CycleInputs(
        pose=arrivals.pose,
        tendon_state=arrivals.tendon_state,
        request=action,
        law=None if request is None else request.law,
        reference=None if request is None else request.reference,
        unreadable=dict(arrivals.unreadable),
        unreadable_detail=arrivals.detail,
        others=dict(arrivals.others),
        missed_ticks=missed,
        pose_lag=arrivals.pose_lag,
        readings=dict(arrivals.readings),
        reading_lags=dict(arrivals.reading_lags),
        jog=None if request is None else request.jog,
        settings={} if request is None or request.settings is None else request.settings,
    )


def _in_words(record: CycleRecord) -> str:
    """Mode and reason."""
    return f"{record.mode.value}: {record.reason}" if record.reason else record.mode.value


def _holding(state: CycleState) -> bool:
    """True if any tendon may still be taut."""
    return state.mode in (*ACTIVE, Mode.RELEASING) or is_taut(state)
