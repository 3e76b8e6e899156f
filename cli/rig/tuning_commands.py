"""`tendond set`, `tendond rig get`: options and help."""

from typing import Annotated

import typer

from tendond.cli.completion import tunable_settings
from tendond.cli.options import Config, Json


def set_(
    settings: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[KEY=VALUE]...", help="Tunable keys with their values.", autocompletion=tunable_settings
        ),
    ] = None,
    configured: Annotated[
        bool, typer.Option("--configured", help="Go back to the configuration's values, of all keys or of those given.")
    ] = False,
    unchecked: Annotated[
        bool, typer.Option("--unchecked", help="Do not compute beforehand whether the loop is stable.")
    ] = False,
    config: Config = None,
) -> None:
    """Tune gains and limits of a running controller.

    They are checked like a configuration's and move to their new value at a bounded rate, while the arm tracks; some
    keys change only while idle. A key may be shortened: alpha1=900. The configuration's file is not changed.

    Example: tendond set control.laws.backstepping.alpha1=900 limits.tension_max=40 --config rig.toml
    """
    from tendond.cli.rig.tuning import set_values

    if not (settings or configured):
        raise typer.BadParameter("give KEY=VALUE, or --configured; 'tendond rig get' lists the keys")
    set_values(settings or [], config, configured=configured, unchecked=unchecked)


def get(config: Config = None, json: Json = False) -> None:
    """List the tunable gains and limits.

    With the value in use, the configured one, what is allowed, and how fast it changes.

    Example: tendond rig get --config rig.toml
    """
    from tendond.cli.rig.tuning import show_values

    show_values(config, as_json=json)
