"""`tendond mocap` and `tendond rig vicon`: tip poses from the cameras."""

from pathlib import Path

from tendond.bus.systemd import Supervisor
from tendond.cli.common import load_config, present, say, say_to, stop_on_signals
from tendond.daemon.runtime.realtime import keep_up
from tendond.drivers.host import Host
from tendond.drivers.mocap.process import MocapDriver
from tendond.drivers.mocap.source import place_of


def run_cameras(config_file: Path | None, name: str) -> None:
    """Run until a signal comes; see `tendond mocap --help`.

    Args:
        config_file: configuration.
        name: section that is named where there is none: mocap or vicon.

    Raises:
        TendondError: the configuration cannot be used, there is no controller, or nothing can be heard.
    """
    config = load_config(config_file)
    section = present(config.cameras, name, config_file)
    supervisor = Supervisor()
    folder = Path() if config_file is None else config_file.parent
    driver = MocapDriver(config, section, Host(stop_on_signals(), say_to(supervisor), supervisor), folder)
    base = f"relative to '{section.base}'" if section.base else "in the cameras' world"
    say(f"rig '{config.rig.name}': tip '{section.tip}' {base}, from {place_of(section)}")
    for missing in keep_up(config.loop):
        say(f"without real-time guarantees: {missing}")
    driver.run()
