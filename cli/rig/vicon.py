"""`tendond rig vicon`: tip poses from Vicon Tracker."""

from pathlib import Path

from tendond.bus.systemd import Supervisor
from tendond.cli.common import load_config, present, say, say_to, stop_on_signals
from tendond.daemon.runtime.realtime import keep_up
from tendond.drivers.host import Host
from tendond.drivers.vicon.process import ViconDriver


def run_vicon(config_file: Path | None) -> None:
    """Run until a signal comes; see `tendond rig vicon --help`.

    Raises:
        TendondError: the configuration cannot be used, there is no controller, or nothing can be heard.
    """
    config = load_config(config_file)
    section = present(config.vicon, "vicon", config_file)
    supervisor = Supervisor()
    driver = ViconDriver(config, section, Host(stop_on_signals(), say_to(supervisor), supervisor))
    where = f"UDP port {section.port}" if section.source == "udp" else f"DataStream server {section.server}"
    base = f"relative to '{section.base}'" if section.base else "in the Vicon world"
    say(f"rig '{config.rig.name}': tip '{section.tip}' {base}, from {where}")
    for missing in keep_up(config.loop):
        say(f"without real-time guarantees: {missing}")
    driver.run()
