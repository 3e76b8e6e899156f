"""`tendond servo`, `reset`, `reboot`, `scan` and `setup`."""

from pathlib import Path

from tendond.bus.systemd import Supervisor
from tendond.cli.common import load_config, present, say, say_to, stop_on_signals
from tendond.cli.servo.rig import confirm, folder_of, servo_section
from tendond.daemon.errors import DaemonError
from tendond.daemon.runtime.realtime import keep_up
from tendond.drivers.dynamixel.process import ServoProcess, request_reset
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.tools.calibrate import Ask
from tendond.drivers.dynamixel.tools.rig import open_bus
from tendond.drivers.dynamixel.tools.scan import GARBLED, PATIENCE, ports, scan
from tendond.drivers.dynamixel.tools.setup import reboot, set_up
from tendond.drivers.host import Host
from tendond.schemas.config.servo import BAUD_RATES


def run_servo(config_file: Path | None) -> None:
    """Run until a signal comes; see `tendond servo --help`.

    Raises:
        TendondError: no calibration for this rig, no controller, or servos or drives that do not meet the requirements.
    """
    config = load_config(config_file)
    section = present(config.servo, "servo", config_file)
    supervisor = Supervisor()
    host = Host(stop_on_signals(), say_to(supervisor), supervisor)
    for missing in keep_up(config.loop):
        say(f"without real-time guarantees: {missing}")
    if config.drives is None:
        ServoProcess(config, section, folder_of(config_file), host).run()
        return
    from tendond.drivers.cia402.process import DriveProcess  # needs the extra

    DriveProcess(config, section, config.drives, folder_of(config_file), host).run()


def reset_servos(config_file: Path | None, with_reboot: bool) -> None:
    """Request the running driver to clear its fault.

    Raises:
        TendondError: there is no driver, or it refused.
    """
    reply = request_reset(load_config(config_file), reboot=with_reboot)
    if not reply.done:
        raise DaemonError(reply.message)
    print(reply.message)


def scan_servos(config_file: Path | None, port: str | None, last_id: int, patience: float = PATIENCE) -> None:
    """Print every servo that replies.

    Raises:
        DaemonError: none does.
    """
    section = servo_section(config_file)
    names = [port] if port else ports() or [section.port]
    heard: list[str] = []

    def keep(line: str) -> None:
        heard.append(line)
        say(line)

    count = 0
    for found in scan(names, section.reply_timeout, last_id, progress=keep, patience=patience):
        print(found)
        count += 1
    if not count:
        rates = f"{BAUD_RATES[0]} to {BAUD_RATES[-1]} bit/s"
        beyond = "" if last_id == table.ID.maximum else f" ids above {last_id} were not searched;"
        garbled = " the replies are garbled: plug in one servo at a time;" if _garbled(heard) else ""
        raise DaemonError(
            f"no servo replies on {', '.join(names)}, ids 0 to {last_id}, {rates}:{beyond}{garbled} is the power on, is"
            " the adapter's latency timer 1 ms?"
        )


def _garbled(heard: list[str]) -> bool:
    return any(GARBLED in line for line in heard)


def set_up_servo(config_file: Path | None, old: int, new: int | None, at: int | None, yes: bool, ask: Ask) -> None:
    """Set id, rate and the required settings, once the operator has confirmed it.

    Raises:
        TendondError: see `set_up`; or the operator did not confirm.
    """
    section = servo_section(config_file)
    with open_bus(section, at) as bus:
        target = old if new is None else new
        question = (
            f"{section.port}: set servo {old} to id {target}, extended position mode, {section.baudrate} bit/s, the"
            " factory's limits? Only one servo may have this id."
        )
        confirm(question, yes, ask)
        changed = set_up(bus, old, target, section)
    print(f"servo {target}: " + (", ".join(changed) or "already set up"))


def reboot_servos(config_file: Path | None, ids: list[int], yes: bool, ask: Ask) -> None:
    """Reboot servos, while no driver uses the port.

    Raises:
        TendondError: a servo does not reply, before or afterwards; or the operator did not confirm.
    """
    section = servo_section(config_file)
    with open_bus(section) as bus:
        which = ", ".join(map(str, ids))
        confirm(f"Reboot servo {which}? Their torque goes off: a bent robot straightens. Support it.", yes, ask)
        for one in ids:
            errors = reboot(bus, one)
            print(f"servo {one}: rebooted" + (f"; errors before: {errors}" if errors else ""))
