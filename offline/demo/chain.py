"""Controller and simulated robot as processes, driven as an operator drives them: with or without the drivers."""

import socket
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import zenoh
from rich.console import Console
from rich.progress import Progress

from tendond.bus.client import BusError, StoppedError, open_client
from tendond.bus.operator import ask, status_in
from tendond.bus.subscription import Subscription
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.calibration import Calibration, TendonCalibration, now, save_calibration
from tendond.offline.demo.report import report_wires
from tendond.offline.processes import (
    POLL_SECONDS,
    START_SECONDS,
    end,
    free_port,
    progress_columns,
    start,
    tip_in_words,
)
from tendond.schemas.config.presets import WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.keys import SERVO_HEALTH, key
from tendond.schemas.messages import Mode, ServoHealth
from tendond.schemas.requests import ControlAction, ControlReply

RIG = "demo"

Report = Callable[[Path, Path, Console], None]


def run_chain(out: Path, text: str, hold: float, report: Report, *, lockstep: bool = False) -> None:
    """Run controller and simulator as two processes.

    Args:
        out: folder for log, configuration and report.
        text: configuration, TOML, without [rig] and [bus].
        hold: time of tracking [s].
        report: called with the folder, the log and a console.
        lockstep: without a clock, a cycle for each pose: a busy computer loses none.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    pace = ("--lockstep",) if lockstep else ()
    config_file, log_file = out / "rig.toml", out / "demo.mcap"
    try:
        out.mkdir(parents=True, exist_ok=True)
        log_file.unlink(missing_ok=True)
        config_file.write_text(f'{text}\n[rig]\nname = "{RIG}"\n\n[bus]\nendpoint = "{endpoint}"\n', encoding="utf-8")
        commands = {
            "controller": ("run", "--config", str(config_file), "--log", str(log_file), *pace),
            "simulator": ("simulate", "--config", str(config_file), *pace),
        }
        demo = _Demo(endpoint, commands, hold)
        how = "in lockstep" if lockstep else "in real time at 100 Hz"
        demo.console.print(f"Simulator and controller: two processes on Zenoh, {how}")
        demo.run()
        report(out, log_file, demo.console)
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error


def run_wired_chain(out: Path, text: str, hold: float, report: Report) -> None:
    """Run controller, Vicon driver, servo driver and the emulated hardware; arguments as of `run_chain`.

    Raises:
        TendondError: a process could not be started, or failed.
    """
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    config_file, log_file, port = out / "rig.toml", out / "demo.mcap", out / "ttyServos"
    try:
        out.mkdir(parents=True, exist_ok=True)
        log_file.unlink(missing_ok=True)
        wiring = f'[bus]\nendpoint = "{endpoint}"\n\n[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n'
        servos = f'[servo]\nport = "{port.absolute()}"\n{WIRED_SERVO}'
        text = f'{text}\n[rig]\nname = "{RIG}"\n\n{wiring}{WIRED_VICON}\n{servos}'
        config_file.write_text(text, encoding="utf-8")
        signs: tuple[Literal[-1, 1], ...] = (1, -1, 1, -1)
        tendons = (
            TendonCalibration(servo=index + 1, zero=2048, sign=sign, spool_radius=ServoSection().spool_radius)
            for index, sign in enumerate(signs)
        )
        save_calibration(out / "calibration.json", Calibration(rig=RIG, date=now(), tendons=tuple(tendons)))
        commands = {
            "controller": ("run", "--config", str(config_file), "--log", str(log_file)),
            "simulator": ("simulate", "--wired", "--config", str(config_file)),
            "vicon driver": ("rig", "vicon", "--config", str(config_file)),
            "servo driver": ("servo", "--config", str(config_file)),
        }
        demo = _Demo(endpoint, commands, hold, {"servo driver": port})
        demo.console.print(
            "Rod <- servos (emulated) <- serial line <- servo driver <- Zenoh <- controller <- Zenoh <- Vicon driver"
            " <- UDP <- Tracker (simulated) <- rod: four processes in real time"
        )
        demo.run()
        report(out, log_file, demo.console)
        report_wires(out, log_file, demo.health, demo.console)
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error


class _Demo:
    """Processes, and an operator who arms, waits and stops.

    Args:
        endpoint: the controller's endpoint.
        commands: arguments of each process, by name; ended in the reverse order.
        hold: time of tracking [s].
        needs: a path that a process waits for before it is started, by the process' name.

    Attributes:
        health: state of the servos' serial line, last reported by the driver; none without a driver.
    """

    def __init__(
        self,
        endpoint: str,
        commands: Mapping[str, Sequence[str]],
        hold: float,
        needs: Mapping[str, Path] | None = None,
    ) -> None:
        self.console = Console()
        self._endpoint = endpoint
        self._commands = commands
        self._hold = hold
        self._needs = needs or {}
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self.health: ServoHealth | None = None

    def run(self) -> None:
        """Start the processes, drive them, end them."""
        try:
            for name, arguments in self._commands.items():
                self._await(name)
                self._processes[name] = start(*arguments)
            with open_client(self._endpoint, START_SECONDS, self._has_ended) as session:
                healths = Subscription(session, key(RIG, SERVO_HEALTH), ServoHealth)
                self._drive(session)
                self.health = healths.newest()
        except StoppedError:
            self._watch()
        finally:
            codes = {name: end(process) for name, process in reversed(self._processes.items())}
        for name, code in codes.items():
            if code:
                raise DaemonError(f"the {name} exited with {code}; see its messages above")

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
        """Check that both processes are alive."""
        for name, process in self._processes.items():
            if process.poll() is not None:
                raise DaemonError(f"the {name} exited with {process.returncode}; see its messages above")

    def _ask(self, session: zenoh.Session, action: ControlAction) -> ControlReply:
        self._watch()
        try:
            return ask(session, RIG, action)
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
                    raise DaemonError(f"the demo could not be armed: {reply.message}")
                time.sleep(POLL_SECONDS)
            started, elapsed = time.monotonic(), 0.0
            while elapsed < self._hold:
                status = status_in(self._ask(session, ControlAction.STATUS))
                if status.mode is Mode.PROBE:  # the tracking's time counts
                    started = time.monotonic()
                elapsed = time.monotonic() - started
                progress.update(task, completed=elapsed, description=status.mode.value, state=tip_in_words(status))
                if status.mode is Mode.FAULT:
                    late = status.reason.startswith(("overrun", "pose jump", "pose age", "pose stale"))
                    busy = "; is this computer too busy to simulate the robot in real time?" if late else ""
                    raise DaemonError(f"the demo ended in a fault: {status.reason}{busy}")
                time.sleep(POLL_SECONDS)
            progress.update(task, completed=self._hold)
            self._ask(session, ControlAction.STOP)
            while (status := status_in(self._ask(session, ControlAction.STATUS))).mode is Mode.RELEASING:
                progress.update(task, description=status.mode.value, state=tip_in_words(status))
                time.sleep(POLL_SECONDS)
            progress.update(task, description=status.mode.value, state=tip_in_words(status))
