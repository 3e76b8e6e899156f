"""Controller and simulated robot as processes, driven as an operator drives them: with or without the drivers."""

import socket
from collections.abc import Callable
from pathlib import Path
from typing import Literal

from rich.console import Console

from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.calibration import Calibration, TendonCalibration, now, save_calibration
from tendond.offline.demo.operated import Operated
from tendond.offline.demo.report import report_wires
from tendond.offline.processes import free_port
from tendond.schemas.config.presets import WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.servo import ServoSection

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
        demo = Operated(endpoint, RIG, commands, hold)
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
        demo = Operated(endpoint, RIG, commands, hold, {"servo driver": port})
        demo.console.print(
            "Rod <- servos (emulated) <- serial line <- servo driver <- Zenoh <- controller <- Zenoh <- Vicon driver"
            " <- UDP <- Tracker (simulated) <- rod: four processes in real time"
        )
        demo.run()
        report(out, log_file, demo.console)
        report_wires(out, log_file, demo.health, demo.console)
    except OSError as error:
        raise DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out") from error
