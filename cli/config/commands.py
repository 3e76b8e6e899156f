"""The commands about a configuration: their options and their help; what they do stands in `config`."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config, Json, Profile

config = typer.Typer(
    name="config",
    help="Check a configuration, show it, or describe it.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
File = Annotated[Path | None, typer.Argument(metavar="FILE", help="The same as --config.", show_default=False)]


def _chosen(file: Path | None, option: Path | None) -> Path | None:
    if file is not None and option is not None:
        raise typer.BadParameter("give the file once", param_hint="--config")
    return file or option


@config.command("check")
def config_check(
    file: File = None,
    config: Config = None,
    profile: Profile = None,
    model: Annotated[
        bool, typer.Option("--model/--no-model", help="Look with the rod's model, too; it may have to be compiled.")
    ] = True,
    json: Json = False,
) -> None:
    """Say everything that is wrong with a configuration.

    Before a process refuses it. Exit status 2 if anything is.

    Keys, values and ranges, laws and their parameters, whether the rod can reach the reference, what the servos can do.

    Example: tendond config check rig.toml
    """
    from tendond.cli.config.check import run_check

    run_check(_chosen(file, config), profile, as_json=json, model=model)


@config.command("has")
def config_has(
    section: Annotated[str, typer.Argument(help="Its name, as vicon or servo.", show_default=False)],
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Rig configuration, TOML.", show_default=False)],
    or_unreadable: Annotated[
        bool, typer.Option("--or-unreadable", help="Exit with 0 as well where the file cannot be read.")
    ] = False,
) -> None:
    """Tell whether a configuration has a section.

    However it is spelled, and in whatever file that it includes. Exit status 0: it has; 1: it has none; 2: it cannot
    be read. Keys and values are not looked at. Units ask this before they start a driver, with --or-unreadable, so that
    the driver is the one to say what is wrong with the file.

    Example: tendond config has vicon rig.toml
    """
    from tendond.cli.config.has import run_has

    run_has(section, file, or_unreadable=or_unreadable)


@config.command("show")
def config_show(
    file: File = None,
    config: Config = None,
    profile: Profile = None,
    changed: Annotated[bool, typer.Option("--changed", help="Only what differs from the defaults.")] = False,
    comments: Annotated[bool, typer.Option("--comments/--no-comments", help="Unit, range and meaning.")] = True,
    json: Json = False,
) -> None:
    """Print the configuration in effect.

    Defaults filled in, as TOML with a comment for each key.

    Examples: tendond config show rig.toml --changed; tendond config show --profile rig > rig.toml
    """
    from tendond.cli.config.check import run_show

    run_show(_chosen(file, config), profile, changed=changed, comments=comments, as_json=json)


@config.command("schema")
def config_schema() -> None:
    """Print the JSON Schema, by which editors complete.

    Editors with taplo take it from a first line '#:schema ./tendond.schema.json' in the configuration.

    Example: tendond config schema > tendond.schema.json
    """
    from tendond.cli.config.check import run_schema

    run_schema()


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.add_typer(config)
