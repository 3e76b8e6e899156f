"""`tendond servo` and its subcommands: the driver, and what an operator does with servos before it runs."""

import math
from collections.abc import Callable
from pathlib import Path

from tendond.daemon.cli.common import load_config, present, say, say_to, stop_on_signals
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.calibration import (
    Calibration,
    TendonCalibration,
    load_calibration,
    now,
    read_calibration,
    save_calibration,
    set_aside,
)
from tendond.drivers.dynamixel.process import ServoProcess, request_reset
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.tools import energised, home, ports, pretension, scan, set_up
from tendond.notify import Supervisor
from tendond.schemas.config import RigConfig
from tendond.schemas.config_servo import ServoSection

Ask = Callable[[str], str]
TURN_ON_TRIAL = math.radians(30.0)
"""By which a servo is turned so that the operator sees which way it winds [rad]."""


class RefusedByOperatorError(DaemonError):
    """The operator said no."""


def run_servo(config_file: Path | None) -> None:
    """Run until a signal comes; see `tendond servo --help`.

    Raises:
        TendondError: no calibration for this rig, no controller, or servos that are not as they have to be.
    """
    config, section = _load(config_file)
    supervisor = Supervisor()
    ServoProcess(config, section, _folder(config_file), stop_on_signals(), say_to(supervisor), supervisor).run()


def reset_servos(config_file: Path | None) -> None:
    """Ask the running driver to leave its fault.

    Raises:
        TendondError: there is no driver, or it refused.
    """
    reply = request_reset(load_config(config_file))
    if not reply.done:
        raise DaemonError(reply.message)
    print(reply.message)


def scan_servos(config_file: Path | None, port: str | None, last_id: int) -> None:
    """Print every servo that answers.

    Raises:
        DaemonError: none does.
    """
    section = load_config(config_file).servo or ServoSection()
    names = [port] if port else ports() or [section.port]
    count = 0
    for found in scan(names, section.answer_timeout, last_id, progress=say):
        print(found)
        count += 1
    if not count:
        raise DaemonError(f"no servo answers on {', '.join(names)} up to id {last_id}: is the power on?")


def set_up_servo(config_file: Path | None, old: int, new: int | None, at: int | None, yes: bool, ask: Ask) -> None:
    """Set id, mode and rate of one servo, once the operator has confirmed it.

    Raises:
        TendondError: see `set_up`; or the operator said no.
    """
    section = load_config(config_file).servo or ServoSection()
    with ServoBus(section.port, at or section.baudrate, section.answer_timeout) as bus:
        target = old if new is None else new
        question = (
            f"{section.port}: set servo {old} to id {target}, extended position mode, {section.baudrate} bit/s?"
            " Only one servo may have this id."
        )
        _confirm(question, yes, ask)
        changed = set_up(bus, old, target, section.baudrate)
    print(f"servo {target}: " + (", ".join(changed) or "was set up already"))


def home_servos(config_file: Path | None, yes: bool, ask: Ask) -> None:
    """Bring every tendon to its zero, one after the other, slowly.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    config, section = _load(config_file)
    stopped = stop_on_signals()
    _, calibration = _calibration(config_file, config, section)
    with _bus(section) as bus:
        spools = []
        for index, tendon in enumerate(calibration.tendons):
            position = bus.read(tendon.servo, table.PRESENT_POSITION)
            held = bool(bus.read(tendon.servo, table.TORQUE_ENABLE))
            spool = Spool(tendon) if held else Spool(tendon).at_power_up(position)
            spools.append(spool)
            place = f"stands {spool.displacement(position) * 1e3:.1f} mm from its zero"
            print(f"tendon {index} (servo {tendon.servo}): {place}{', held' if held else ''}")
        _confirm(
            "Move them to zero, slowly, one after the other? Whole turns that servos forgot are not seen.", yes, ask
        )
        for index, spool in enumerate(spools):
            before, after = home(bus, section, spool, stopped)
            print(f"tendon {index}: from {before * 1e3:.1f} to {after * 1e3:.1f} mm")


def pretension_servos(config_file: Path | None, store: bool, yes: bool, ask: Ask) -> None:
    """Wind every tendon up until it pulls; with `store`, that is its zero from now on.

    Raises:
        TendondError: no calibration, an error of a servo, or the operator said no.
    """
    config, section = _load(config_file)
    stopped = stop_on_signals()
    path, calibration = _calibration(config_file, config, section)
    tendons = list(calibration.tendons)
    with _bus(section) as bus:
        _confirm("Wind up each tendon, slowly, one after the other, until it pulls?", yes, ask)
        for index, tendon in enumerate(tendons):
            spool = Spool(tendon).at_power_up(bus.read(tendon.servo, table.PRESENT_POSITION))
            taut = pretension(bus, section, spool, stopped)
            print(f"tendon {index} (servo {tendon.servo}): pulls from {spool.displacement(taut) * 1e3:.2f} mm on")
            tendons[index] = tendon.model_copy(update={"zero": taut % table.TICKS_PER_TURN})
    if store:
        kept = set_aside(path)
        save_calibration(path, Calibration(rig=calibration.rig, date=now(), tendons=tuple(tendons)))
        print(f"{path}: the new zeros{'' if kept is None else f'; the old ones are in {kept.name}'}")


def calibrate_servos(config_file: Path | None, ask: Ask) -> None:
    """Ask for zero, sign and spool of each tendon; what is done is kept, so that it can be gone on with.

    Raises:
        TendondError: an error of a servo, or a file that cannot be written.
    """
    config, section = _load(config_file)
    path = _folder(config_file) / section.calibration
    ids = section.servo_ids(len(config.rod.tendon_positions))
    done = _begun(path, config, ids)
    if len(done) == len(ids):
        kept = set_aside(path)
        print(f"{path} is complete: starting anew, it is kept as {kept.name if kept else path.name}")
        done = []
    elif done:
        print(f"going on with tendon {len(done)}: {len(done)} of {len(ids)} are in {path}")
    with _bus(section) as bus:
        for index in range(len(done), len(ids)):
            done.append(_calibrate_one(bus, section, index, ids[index], ask))
            save_calibration(path, Calibration(rig=config.rig.name, date=now(), tendons=tuple(done)))
            print(f"tendon {index}: kept in {path}")


def _begun(path: Path, config: RigConfig, ids: tuple[int, ...]) -> list[TendonCalibration]:
    """What an earlier, unfinished calibration of this rig has already."""
    if not path.exists():
        return []
    calibration = read_calibration(path)
    servos = tuple(tendon.servo for tendon in calibration.tendons)
    if calibration.rig != config.rig.name or servos != ids[: len(servos)]:
        raise DaemonError(f"{path}: is of rig '{calibration.rig}', servos {list(servos)}: name another file")
    return list(calibration.tendons)


def _calibrate_one(bus: ServoBus, section: ServoSection, index: int, servo: int, ask: Ask) -> TendonCalibration:
    """Zero with the robot straight and the tendon just taut, sign by a small turn, spool by the operator's rule."""
    if bus.read(servo, table.TORQUE_ENABLE):
        raise ServoError(f"servo {servo}: its torque is on: run 'tendond servo home', or switch its power off and on")
    ask(f"Tendon {index} (servo {servo}): robot straight, tendon slack but on its spool. Enter to go on:")
    radius = _number(ask, "Radius of the spool to the tendon's middle in mm", section.spool_radius * 1e3, 1.0, 200.0)
    trial = TendonCalibration(
        servo=servo, zero=bus.read(servo, table.PRESENT_POSITION), sign=1, spool_radius=radius * 1e-3
    )
    answer = "again"
    while answer not in {"yes", "no"}:
        if answer == "again":
            _turn_and_return(bus, section, Spool(trial))
        answer = ask("It turned 30 degrees and back. Did the first turn let the tendon OUT? yes, no or again:")
    signed = trial.model_copy(update={"sign": 1 if answer == "yes" else -1})
    taut = pretension(bus, section, Spool(signed))
    print(f"tendon {index}: zero at {taut % table.TICKS_PER_TURN} ticks, where it begins to pull")
    return signed.model_copy(update={"zero": taut % table.TICKS_PER_TURN})


def _turn_and_return(bus: ServoBus, section: ServoSection, spool: Spool) -> None:
    with energised(bus, section, spool) as motion:
        for target in (-TURN_ON_TRIAL * spool.calibration.spool_radius, 0.0):
            motion.move(target, section.pretension_load, lambda: False)


def _number(ask: Ask, question: str, default: float, least: float, most: float) -> float:
    while True:
        answer = ask(f"{question} [{default:g}]:")
        try:
            value = float(answer) if answer else default
        except ValueError:
            value = math.nan
        if least <= value <= most:
            return value
        print(f"a number from {least:g} to {most:g}, please")


def _confirm(question: str, yes: bool, ask: Ask) -> None:
    if not yes and ask(f"{question} yes or no:") != "yes":
        raise RefusedByOperatorError("nothing was done: the answer was not 'yes'")


def _load(config_file: Path | None) -> tuple[RigConfig, ServoSection]:
    config = load_config(config_file)
    return config, present(config.servo, "servo", config_file)


def _calibration(config_file: Path | None, config: RigConfig, section: ServoSection) -> tuple[Path, Calibration]:
    path = _folder(config_file) / section.calibration
    return path, load_calibration(path, config.rig.name, section.servo_ids(len(config.rod.tendon_positions)))


def _bus(section: ServoSection) -> ServoBus:
    return ServoBus(section.port, section.baudrate, section.answer_timeout)


def _folder(config_file: Path | None) -> Path:
    return Path() if config_file is None else config_file.parent


def ask_terminal(question: str) -> str:
    """Put a question to the operator; the answer in small letters.

    Raises:
        RefusedByOperatorError: there is nobody to answer.
    """
    try:
        return input(f"{question} ").strip().lower()
    except EOFError:
        raise RefusedByOperatorError("nothing was done: nobody answers; give --yes if you are sure") from None
