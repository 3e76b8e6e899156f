"""`tendond bridge ros2`: a rig among the nodes of ROS 2."""

from pathlib import Path

import typer
from pydantic import ValidationError

from tendond.bus.systemd import Supervisor
from tendond.cli.common import load_config, say, say_to, stop_on_signals
from tendond.cli.extras import need
from tendond.drivers.host import Host
from tendond.schemas.config.machine import BusSection


def run_bridge(config_file: Path | None, router: str, domain: int, distribution: str) -> None:
    """Run until a signal comes; see `tendond bridge ros2 --help`.

    Raises:
        TendondError: the configuration cannot be used, or there is no controller or router.
    """
    config = load_config(config_file)
    need("rosbags")  # before the rod model, whose import takes a second
    from tendond.drivers.ros2.bridge import Bridge, RosOptions
    from tendond.model.numerics.announce import announce_compilation

    try:
        BusSection(endpoint=router)
    except ValidationError as error:
        raise typer.BadParameter(
            f"'{router}' has not the form tcp/HOST:PORT, for instance tcp/localhost:7447", param_hint="--router"
        ) from error
    announce_compilation(say)
    supervisor = Supervisor()
    host = Host(stop_on_signals(), say_to(supervisor), supervisor)
    bridge = Bridge(config, RosOptions(distribution, domain, router), host)
    say(f"rig '{config.rig.name}': ROS 2 {distribution}, domain {domain}, router {router}")
    bridge.run()
