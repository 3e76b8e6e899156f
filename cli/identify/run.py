"""`tendond identify run`: a plan on the rig, by an operator's requests to a controller that is started for it."""

import subprocess
import time
from datetime import UTC, datetime
from pathlib import Path

import zenoh
from rich.console import Console
from rich.progress import Progress

from tendond.bus.client import BusError, StoppedError, open_client
from tendond.bus.operator import ask, status_in
from tendond.cli.common import load_config, say
from tendond.cli.identify.fit import kinds, plan_lines, rig_of_model
from tendond.daemon.errors import DaemonError, UsageError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.identification.data import WEIGHT_NOTE
from tendond.offline.identification.dry_run import dry_run
from tendond.offline.identification.plan import Plan, Request, propose
from tendond.offline.processes import (
    END_SECONDS,
    POLL_SECONDS,
    START_SECONDS,
    end,
    progress_columns,
    start,
    tip_in_words,
)
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import ControlAction, ControlReply, ControlRequest, Mode, Status

PATIENCE_SECONDS = 10.0
"""For which a refused request is put again: the arm may still be releasing."""


def run_plan(config_file: Path | None, log: Path | None, parts: str, reach: float, weight: float, *, yes: bool) -> None:
    """Rehearse a plan, ask, and carry it out; see `tendond identify run --help`.

    Raises:
        TendondError: a configuration that leaves no way to go, a plan that the dry run does not survive, a controller
            that cannot be started, a fault on the way.
    """
    config = load_config(config_file)
    if log is None:
        log = Path("log") / f"{config.rig.name}-identify-{datetime.now(UTC):%Y%m%dT%H%M%SZ}.mcap"
    if log.exists():
        raise UsageError(f"{log}: is there already: a log is never overwritten; choose another --log")
    _refuse_another_controller(config)
    announce_compilation(say)
    plan = propose(config, kinds(parts), reach)
    dry = dry_run(rig_of_model(config, weight), plan)
    for line in plan_lines(plan, dry):
        print(line, flush=True)
    if not yes and input(f"Weight on the tip: {weight:g} kg. Is the arm free to move? [y/N] ").strip() not in (
        "y",
        "Y",
    ):
        raise DaemonError("not begun: nobody said yes")
    command = ["run", "--log", str(log), "--note", f"{WEIGHT_NOTE}={weight}"]
    if config_file is not None:
        command += ["--config", str(config_file)]
    # A session of its own: Ctrl-C is for this process, which stops the arm before it ends the controller.
    controller = start(*command, own_session=True)
    try:
        with open_client(config.bus.endpoint, START_SECONDS, lambda: controller.poll() is not None) as session:
            _Operator(config, session, controller).carry_out(plan)
    except StoppedError:
        raise DaemonError(f"the controller ended with {controller.returncode}; what it said stands above") from None
    finally:
        code = end(controller)
    if code:
        raise DaemonError(f"the controller ended with {code}; what it said stands above")
    print(f"recorded: {log}\nnext:     tendond identify {log}")


def _refuse_another_controller(config: RigConfig) -> None:
    """The plan must not reach a controller that writes another log."""
    try:
        with open_client(config.bus.endpoint, 0.0):
            pass
    except BusError:
        return
    raise UsageError(f"a controller runs at {config.bus.endpoint} already: end it first, this command starts its own")


class _Operator:
    """Who puts the plan's requests.

    Args:
        config: of the rig. session: to the controller. controller: its process.
    """

    def __init__(self, config: RigConfig, session: zenoh.Session, controller: "subprocess.Popen[bytes]") -> None:
        self._rig = config.rig.name
        self._session = session
        self._controller = controller

    def carry_out(self, plan: Plan) -> None:
        """All requests, each at its time since the one before.

        Raises:
            DaemonError: a fault, or a request that was refused for good; the arm is released.
        """
        console = Console()
        with Progress(*progress_columns(), console=console, disable=not console.is_terminal) as progress:
            task = progress.add_task("waiting", total=plan.duration, seen="")
            self._await_tip()
            try:
                before = 0.0
                last = time.monotonic()
                for request in (*plan.requests, Request(plan.duration, ControlAction.STATUS)):
                    until = last + request.time - before
                    while (now := time.monotonic()) < until:
                        status = self._status()
                        done = request.time - (until - now)
                        progress.update(task, completed=done, description=status.mode.value, seen=tip_in_words(status))
                        time.sleep(min(POLL_SECONDS, max(0.0, until - time.monotonic())))
                    self._put(request)
                    before, last = request.time, time.monotonic()
                progress.update(task, completed=plan.duration)
            finally:
                self._release()

    def _await_tip(self) -> None:
        """Until camera and servos are there."""
        deadline = time.monotonic() + START_SECONDS
        while not self._sees_the_tip():
            if time.monotonic() > deadline:
                raise DaemonError(f"no pose of the tip within {START_SECONDS:g} s: start the camera's driver")
            time.sleep(POLL_SECONDS)

    def _sees_the_tip(self) -> bool:
        """Whether there is a pose; a controller that is still starting does not answer."""
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
            raise DaemonError(f"the controller ended with {self._controller.returncode}; what it said stands above")
        return ask(self._session, self._rig, request)

    def _release(self) -> None:
        """Stop whatever goes on, and wait until the tendons are slack."""
        deadline = time.monotonic() + END_SECONDS
        try:
            self._ask(ControlRequest(action=ControlAction.STOP))
            while time.monotonic() < deadline and self._status().mode is not Mode.IDLE:
                time.sleep(POLL_SECONDS)
        except (BusError, DaemonError) as error:
            say(f"stopping: {error}")
