"""The group `tendond bridge`: options and help of the bridges to other middleware."""

from typing import Annotated

import typer

from tendond.cli.options import Config, Distro, known_distribution
from tendond.drivers.ros2.distributions import DEFAULT_DISTRIBUTION, DOMAIN_MAX, ROUTER

bridge = typer.Typer(
    name="bridge", help="Connect a rig to other middleware.", no_args_is_help=True, rich_markup_mode=None
)


@bridge.callback()
def group() -> None:
    """Connect a rig to other middleware."""


@bridge.command("ros2")
def ros2(
    config: Config = None,
    router: Annotated[str, typer.Option("--router", help="Endpoint of ROS 2's Zenoh router, rmw_zenohd.")] = ROUTER,
    domain: Annotated[
        int, typer.Option("--domain", envvar="ROS_DOMAIN_ID", min=0, max=DOMAIN_MAX, help="Domain of ROS 2.")
    ] = 0,
    distro: Distro = DEFAULT_DISTRIBUTION,
) -> None:
    """Connect a rig to ROS 2 nodes that use rmw_zenoh.

    Needs the extra 'ros2', no ROS. Publishes poses, tendons, frames, the rod's shape and diagnostics; takes goals, and
    the services arm, stop, reset and status. Runs until Ctrl-C or SIGTERM.

    Example: tendond bridge ros2 --config rig.toml --distro jazzy
    """
    from tendond.cli.bridge.ros2 import run_bridge
    from tendond.cli.signals import exit_on_signals

    exit_on_signals()
    run_bridge(config, router, domain, known_distribution(distro))
