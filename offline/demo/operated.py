"""Processes of a rig, and an operator who arms, waits and stops; their output together."""

import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import zenoh
from rich.console import Console
from rich.progress import Progress

from tendond.bus.client import BusError, StoppedError, open_client
from tendond.bus.operator import ask, status_in
from tendond.bus.subscription import Subscription
from tendond.daemon.errors import DaemonError
from tendond.offline.processes import (
    POLL_SECONDS,
    START_SECONDS,
    Output,
    end,
    end_all,
    progress_columns,
    start,
    tip_in_words,
)
from tendond.schemas.keys import SERVO_HEALTH, key
from tendond.schemas.messages import Mode, ServoHealth
from tendond.schemas.requests import ControlAction, ControlReply


class Operated:
    """Processes, and an operator who arms, waits and stops.

    Each line that a process prints stands on the console behind its name. The terminal's Ctrl-C reaches this process
    alone, which then ends the first of the others, the controller, which releases the tendons, and then the rest.

    Args:
        endpoint: the controller's endpoint. rig: name of the rig.
        commands: arguments of each process, by name, the controller's first; ended in the reverse order.
        hold: time of tracking [s].
        needs: a path that a process waits for before it is started, by the process' name.
        name: of the whole, in messages.

    Attributes:
        health: state of the servos' serial line, last reported by the driver; none without a driver.
    """

    def __init__(
        self,
        endpoint: str,
        rig: str,
        commands: Mapping[str, Sequence[str]],
        hold: float,
        needs: Mapping[str, Path] | None = None,
        name: str = "demo",
    ) -> None:
        self.console = Console()
        self._endpoint = endpoint
        self._rig = rig
        self._commands = commands
        self._hold = hold
        self._needs = needs or {}
        self._name = name
        self._width = max(map(len, (*commands, "operator")))
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._outputs: list[Output] = []
        self.health: ServoHealth | None = None

    def run(self) -> None:
        """Start the processes, drive them, end them.

        Raises:
            TendondError: a process could not be started, or failed; or the arm could not be armed, or had a fault.
        """
        try:
            try:
                for name, arguments in self._commands.items():
                    self._await(name)
                    self._start(name, arguments)
                with open_client(self._endpoint, START_SECONDS, self._has_ended) as session:
                    healths = Subscription(session, key(self._rig, SERVO_HEALTH), ServoHealth)
                    self._drive(session)
                    self.health = healths.newest()
            except StoppedError:
                self._watch()
            codes = {name: end(process) for name, process in reversed(self._processes.items())}
        finally:
            end_all(self._processes.values())
            for output in self._outputs:
                output.join()
        for name, code in codes.items():
            if code:
                raise DaemonError(f"the {name} exited with {code}; see its messages above")

    def say(self, name: str, line: str) -> None:
        """Print a line of a process behind its name."""
        self.console.print(
            f"{name:<{self._width}} | {line}", markup=False, highlight=False, emoji=False, soft_wrap=True
        )

    def _start(self, name: str, arguments: Sequence[str]) -> None:
        process = start(*arguments, own_session=True, piped=True)
        self._processes[name] = process
        self._outputs.append(Output(process, lambda line: self.say(name, line)))

    def _await(self, name: str) -> None:
        """Wait for what a process needs."""
        deadline = time.monotonic() + START_SECONDS
        while name in self._needs and not self._needs[name].exists():
            self._watch()
            if time.monotonic() > deadline:
                raise DaemonError(f"the {name} cannot be started: there is no {self._needs[name]}")
            time.sleep(POLL_SECONDS)

    def _has_ended(self) -> bool:
        return any(process.poll() is not None for process in self._processes.values())

    def _watch(self) -> None:
        """Check that all processes are alive."""
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise DaemonError(f"the {name} exited with {process.returncode}; see its messages above")

    def _ask(self, session: zenoh.Session, action: ControlAction) -> ControlReply:
        self._watch()
        try:
            return ask(session, self._rig, action)
        except BusError:
            self._watch()
            raise

    def _arm(self, session: zenoh.Session) -> ControlReply:
        """Ask the controller to arm; one that is silent is still starting: it may have kernels to compile."""
        try:
            return self._ask(session, ControlAction.ARM)
        except BusError as error:
            return ControlReply(done=False, message=str(error))

    def _drive(self, session: zenoh.Session) -> None:
        """Arm, watch it track and hold, stop, and wait until the tendons are slack."""
        with Progress(*progress_columns(), console=self.console, disable=not self.console.is_terminal) as progress:
            task = progress.add_task("arming", total=self._hold, state="")
            deadline = time.monotonic() + START_SECONDS
            while not (reply := self._arm(session)).done:
                progress.update(task, state=reply.message)
                if time.monotonic() > deadline:
                    raise DaemonError(f"the {self._name} could not be armed: {reply.message}")
                time.sleep(POLL_SECONDS)
            self.say("operator", reply.message)
            started, elapsed, shown = time.monotonic(), 0.0, Mode.PROBE
            while elapsed < self._hold:
                status = status_in(self._ask(session, ControlAction.STATUS))
                if status.mode in (Mode.PROBE, Mode.PRETENSION):  # the tracking's time counts
                    started = time.monotonic()
                elapsed = time.monotonic() - started
                progress.update(task, completed=elapsed, description=status.mode.value, state=tip_in_words(status))
                if status.mode is Mode.FAULT:
                    late = status.reason.startswith(("overrun", "pose jump", "pose age", "pose stale"))
                    busy = "; is this computer too busy to simulate the robot in real time?" if late else ""
                    raise DaemonError(f"the {self._name} ended in a fault: {status.reason}{busy}")
                if status.mode is Mode.TRACKING and shown is not Mode.TRACKING:
                    self.say("operator", f"tracking for {self._hold:.3g} s")
                shown = status.mode
                time.sleep(POLL_SECONDS)
            progress.update(task, completed=self._hold)
            self.say("operator", self._ask(session, ControlAction.STOP).message)
            while (status := status_in(self._ask(session, ControlAction.STATUS))).mode is Mode.RELEASING:
                progress.update(task, description=status.mode.value, state=tip_in_words(status))
                time.sleep(POLL_SECONDS)
            progress.update(task, description=status.mode.value, state=tip_in_words(status))
