"""Recording of a plan on the rig: an operator's requests to a controller that is started for it."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, StoppedError, open_client
from tendond.bus.operator import ask, status_in
from tendond.bus.subscription import Subscription
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.identification.excitation.plan import IdentificationPlan, Request
from tendond.offline.identification.recordings.weights import WEIGHT_NOTE
from tendond.offline.processes import (
    END_SECONDS,
    POLL_SECONDS,
    START_SECONDS,
    end,
    progress_columns,
    start,
    tip_in_words,
)
from tendond.offline.progress import bars
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import SIMULATOR_TRUTH, key
from tendond.schemas.messages import Mode, SimulatorTruth, Status
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

PATIENCE_SECONDS = 10.0
"""Time for which a refused request is repeated: the tendons may still be releasing."""


def record_plan(
    config: RigConfig,
    config_file: Path | None,
    plan: IdentificationPlan,
    log: Path,
    weight: float,
    say: Callable[[str], None],
) -> None:
    """Start a controller, carry out the plan, and end the controller.

    Args:
        config: the rig's configuration.
        config_file: its file; none: the built-in configuration.
        plan: the plan to carry out.
        log: MCAP file to create.
        weight: mass fixed to the tip [kg], for the log's metadata.
        say: prints a line for people.

    Raises:
        DaemonError: the controller cannot be started, a fault, or a request that was refused.
    """
    command = ["run", "--log", str(log), "--note", f"{WEIGHT_NOTE}={weight}"]
    if config_file is not None:
        command += ["--config", str(config_file)]
    # A session of its own: Ctrl-C is for this process, which stops the arm before it ends the controller.
    controller = start(*command, own_session=True)
    try:
        with open_client(config.bus.endpoint, START_SECONDS, lambda: controller.poll() is not None) as session:
            _Operator(config, session, controller, say).carry_out(plan)
    except StoppedError:
        raise DaemonError(f"the controller ended with {controller.returncode}; see its messages above") from None
    finally:
        code = end(controller)
    if code:
        raise DaemonError(f"the controller ended with {code}; see its messages above")


def refuse_another_controller(config: RigConfig) -> None:
    """Check that no controller is running: the plan must not reach one that writes another log.

    Raises:
        UsageError: a controller is running.
    """
    try:
        with open_client(config.bus.endpoint, 0.0):
            pass
    except BusError:
        return
    raise UsageError(f"a controller runs at {config.bus.endpoint} already: end it first, this command starts its own")


class _Operator:
    """Operator who makes the plan's requests.

    Args:
        config: the rig's configuration.
        session: session with the controller.
        controller: its process.
        say: prints a line for people.
    """

    def __init__(
        self,
        config: RigConfig,
        session: zenoh.Session,
        controller: "subprocess.Popen[bytes]",
        say: Callable[[str], None],
    ) -> None:
        self._rig = config.rig.name
        self._drive = config.simulator.drive
        self._truth = Subscription(session, key(config.rig.name, SIMULATOR_TRUTH), SimulatorTruth)
        self._session = session
        self._controller = controller
        self._say = say

    def carry_out(self, plan: IdentificationPlan) -> None:
        """Make all requests, each at its time since the one before.

        Raises:
            DaemonError: a fault, or a request that was refused repeatedly; the tendons are released.
            UsageError: the rig is a simulator with an ideal drive.
        """
        with bars(*progress_columns()) as progress:
            task = progress.add_task("waiting", total=plan.duration, state="")
            self._await_tip()
            self._refuse_ideal_drive()
            try:
                before = 0.0
                last = time.monotonic()
                for request in (*plan.requests, Request(plan.duration, ControlAction.STATUS)):
                    until = last + request.time - before
                    while (now := time.monotonic()) < until:
                        status = self._status()
                        done = request.time - (until - now)
                        progress.update(task, completed=done, description=status.mode.value, state=tip_in_words(status))
                        time.sleep(min(POLL_SECONDS, max(0.0, until - time.monotonic())))
                    self._put(request)
                    before, last = request.time, time.monotonic()
                progress.update(task, completed=plan.duration)
            finally:
                self._release()

    def _await_tip(self) -> None:
        """Wait until camera and servos are running."""
        deadline = time.monotonic() + START_SECONDS
        while not self._sees_the_tip():
            if time.monotonic() > deadline:
                raise DaemonError(f"no pose of the tip within {START_SECONDS:g} s: start the camera's driver")
            time.sleep(POLL_SECONDS)

    def _refuse_ideal_drive(self) -> None:
        """Refuse a simulator that imposes the tensions, before the arm moves: its log could not be fitted to.

        Raises:
            UsageError: it is one.
        """
        if self._drive != "tension":
            return
        time.sleep(POLL_SECONDS)  # for its truth, which comes with each pose
        if self._truth.newest() is not None:
            raise UsageError(
                f"rig '{self._rig}' is a simulator with an ideal drive, which imposes the tensions: there is no servo "
                'to identify and no tendon end to fit to; set simulator.drive = "displacement" and restart it'
            )

    def _sees_the_tip(self) -> bool:
        """Check for a pose; a controller that is still starting does not reply."""
        try:
            return self._status().tip is not None
        except BusError:
            return False

    def _put(self, request: Request) -> None:
        deadline = time.monotonic() + PATIENCE_SECONDS
        wanted = ControlRequest(action=request.action, reference=request.reference)
        while not (reply := self._ask(wanted)).done:
            if time.monotonic() > deadline:
                raise DaemonError(f"the plan's request '{request.action.value}' was refused: {reply.message}")
            time.sleep(POLL_SECONDS)
            self._status()

    def _status(self) -> Status:
        status = status_in(self._ask(ControlRequest(action=ControlAction.STATUS)))
        if status.mode is Mode.FAULT:
            raise DaemonError(f"fault, the tendons are released: {status.reason}")
        return status

    def _ask(self, request: ControlRequest) -> ControlReply:
        if self._controller.poll() is not None:
            raise DaemonError(f"the controller ended with {self._controller.returncode}; see its messages above")
        return ask(self._session, self._rig, request)

    def _release(self) -> None:
        """Stop, and wait until the tendons are slack."""
        deadline = time.monotonic() + END_SECONDS
        try:
            self._ask(ControlRequest(action=ControlAction.STOP))
            while time.monotonic() < deadline and self._status().mode is not Mode.IDLE:
                time.sleep(POLL_SECONDS)
        except (BusError, DaemonError) as error:
            self._say(f"stopping: {error}")
