"""`tendond dashboard`: options and help."""

from typing import Annotated

import typer

from tendond.cli.options import Config


def dashboard(
    config: Config = None,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on; one of the network needs the token that is printed.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port to listen on; 0: a free one.")] = 8780,
) -> None:
    """Show and operate a rig in the browser.

    One page: rod and target in space, tensions, timing, faults; arm, stop (the space bar, too), reset, law, reference,
    gains, and the target by hand. Needs the extra 'dashboard'. The page loads nothing from elsewhere.

    Example: tendond dashboard --config rig.toml
    """
    from tendond.cli.common import stop_on_signals
    from tendond.cli.dashboard.run import run_dashboard

    run_dashboard(config, host, port, stop_on_signals())
