"""The group `tendond config`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import configurations, presets, sections
from tendond.cli.options import Config, Json, Profile

config = typer.Typer(
    name="config",
    help="Check, show and describe configurations.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
File = Annotated[
    Path | None,
    typer.Argument(
        metavar="FILE",
        help="Rig configuration, TOML; same as --config.",
        show_default=False,
        autocompletion=configurations,
    ),
]


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
        bool, typer.Option("--model/--no-model", help="Check with the rod model as well; may compile its kernels.")
    ] = True,
    json: Json = False,
) -> None:
    """Check a configuration and list every error.

    Keys, values and ranges, laws and their parameters, whether the rod reaches the reference, what the servos can do.
    Exit status 2: there are errors.

    Example: tendond config check rig.toml
    """
    from tendond.cli.config.check import run_check

    run_check(_chosen(file, config), profile, as_json=json, model=model)


@config.command("has")
def config_has(
    section: Annotated[
        str,
        typer.Argument(
            help="Name of the section, such as vicon or servo.", show_default=False, autocompletion=sections
        ),
    ],
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE", help="Rig configuration, TOML.", show_default=False, autocompletion=configurations
        ),
    ],
    or_unreadable: Annotated[
        bool, typer.Option("--or-unreadable", help="Exit with 0 if the file cannot be read.")
    ] = False,
) -> None:
    """Test whether a configuration has a section.

    Included files count. Exit status 0: it has; 1: it does not; 2: the file cannot be read. Keys and values are not
    checked. The systemd units run this before they start a driver, with --or-unreadable, so that the driver itself
    reports an unreadable file.

    Example: tendond config has vicon rig.toml
    """
    from tendond.cli.config.has import run_has

    run_has(section, file, or_unreadable=or_unreadable)


@config.command("show")
def config_show(
    file: File = None,
    config: Config = None,
    profile: Profile = None,
    preset: Annotated[
        str | None, typer.Option("--preset", help="Print the [rod] of a robot by name.", autocompletion=presets)
    ] = None,
    changed: Annotated[bool, typer.Option("--changed", help="Print only what differs from the defaults.")] = False,
    comments: Annotated[bool, typer.Option("--comments/--no-comments", help="Print unit, range and meaning.")] = True,
    json: Json = False,
) -> None:
    """Print the effective configuration.

    As TOML, with the defaults filled in and a comment for each key.

    Examples: tendond config show rig.toml --changed; tendond config show --profile rig > rig.toml;
    tendond config show --preset rao-2021 > arm.toml
    """
    from tendond.cli.config.check import run_preset, run_show

    if preset is not None:
        run_preset(preset, comments=comments, as_json=json)
        return
    run_show(_chosen(file, config), profile, changed=changed, comments=comments, as_json=json)


@config.command("schema")
def config_schema() -> None:
    """Print the JSON Schema, for completion in editors.

    Editors with taplo read it from a first line '#:schema ./tendond.schema.json' in the configuration.

    Example: tendond config schema > tendond.schema.json
    """
    from tendond.cli.config.check import run_schema

    run_schema()
