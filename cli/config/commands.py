"""The group `tendond config`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import configurations, presets, sections
from tendond.cli.options import Config, ConfigFile, Json, Profile, chosen_file

config = typer.Typer(
    name="config",
    help="Check, show, describe and migrate configurations.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@config.command("check")
def config_check(
    file: ConfigFile = None,
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

    run_check(chosen_file(file, config), profile, as_json=json, model=model)


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

    Included files count; [mocap] counts as vicon. Exit status 0: it has; 1: it does not; 2: the file cannot be read.
    Keys and values are not checked. The systemd units run this before they start a driver, with --or-unreadable, so
    that the driver itself reports an unreadable file.

    Example: tendond config has vicon rig.toml
    """
    from tendond.cli.config.has import run_has

    run_has(section, file, or_unreadable=or_unreadable)


@config.command("show")
def config_show(
    file: ConfigFile = None,
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
    run_show(chosen_file(file, config), profile, changed=changed, comments=comments, as_json=json)


@config.command("new")
def config_new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="File to write.")] = Path("rig.toml"),
    like: Annotated[
        str | None,
        typer.Option("--like", help="Start from a robot by name, see config presets.", autocompletion=presets),
    ] = None,
    length: Annotated[str | None, typer.Option(help="Length of the backbone [m], or with a unit: 300mm.")] = None,
    diameter: Annotated[str | None, typer.Option(help="Diameter of the backbone [m].")] = None,
    material: Annotated[
        str | None,
        typer.Option(
            help="spring-steel, stainless-steel, nitinol, glass-fibre, carbon-fibre; or E,DENSITY [Pa, kg/m^3]."
        ),
    ] = None,
    mass: Annotated[str | None, typer.Option(help="Mass of backbone, disks, glue and markers [kg]; 0: bare.")] = None,
    tip_mass: Annotated[str | None, typer.Option(help="Mass of a tool on the tip [kg].")] = None,
    tendons: Annotated[str | None, typer.Option(help="Number of tendons, evenly about the axis from +x on.")] = None,
    tendon_radius: Annotated[str | None, typer.Option(help="Distance of the tendons from the axis [m].")] = None,
    tendon_stiffness: Annotated[
        str | None, typer.Option(help="Stiffness of a whole tendon [N/m]. Default: inextensible.")
    ] = None,
    gravity: Annotated[str | None, typer.Option(help="Direction of gravity: -x, +x, -y, +y, -z, +z or none.")] = None,
    damping_ratio: Annotated[str | None, typer.Option(help="Damping ratio of the first mode [-], or 2%.")] = None,
    camera: Annotated[str | None, typer.Option(help="none or vicon.")] = None,
    servos: Annotated[str | None, typer.Option(help="none or dynamixel.")] = None,
    rate: Annotated[str | None, typer.Option(help="Rate of the loop [Hz].")] = None,
    name: Annotated[str | None, typer.Option(help="Name of the rig. Default: the file's.")] = None,
    yes: Annotated[
        bool, typer.Option("--yes", help="Take the defaults of all that is not given, without asking.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file.")] = False,
) -> None:
    """Write a configuration from a dozen answers.

    Asks for what the options do not give, writes a commented file with a first target within the robot's reach, and
    checks it.

    Examples: tendond config new; tendond config new arm.toml --length 0.2 --diameter 1.4mm --material nitinol --yes;
    tendond config new arm.toml --like rao-2021 --yes
    """
    from tendond.cli.config.asking import ask
    from tendond.cli.config.new import run_new

    given = {
        "length": length, "diameter": diameter, "material": material, "mass": mass, "tip_mass": tip_mass,
        "tendons": tendons, "tendon_radius": tendon_radius, "tendon_stiffness": tendon_stiffness, "gravity": gravity,
        "damping_ratio": damping_ratio, "camera": camera, "servos": servos, "rate": rate,
    }  # fmt: skip
    run_new(file, given, like=like, name=name, yes=yes, force=force, ask=ask)


@config.command("presets")
def config_presets(json: Json = False) -> None:
    """List robots by name, with source and assumptions.

    Example: tendond config presets
    """
    from tendond.cli.config.presets import run_presets

    run_presets(as_json=json)


@config.command("mjcf")
def config_mjcf(
    file: ConfigFile = None,
    config: Config = None,
    profile: Profile = None,
    out: Annotated[Path | None, typer.Option("--out", help="File to write, XML. Default: print it.")] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing file.")] = False,
) -> None:
    """Write the simulated robot as MJCF, the model of MuJoCo.

    The robot of [simulator.rod] as 'tendond simulate --plant mujoco' runs it: links on ball joints, tendons through
    sites, a motor and a winch for each. Needs the extra mujoco.

    Example: tendond config mjcf rig.toml --out robot.xml
    """
    from tendond.cli.config.mjcf import run_mjcf

    run_mjcf(chosen_file(file, config), profile, out, force=force)


@config.command("migrate")
def config_migrate(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Rig configuration, TOML.", show_default=False)],
    write: Annotated[
        bool, typer.Option("--write", help="Rewrite the file; the old one is kept beside it, as FILE.v1.")
    ] = False,
) -> None:
    """Rewrite a configuration to the present version.

    Renamed keys, counts of cycles that are seconds now, keys without a meaning; comments and layout stay. Prints the
    difference unless --write is given. Files that it includes are migrated each by itself. A file of an old version
    is read without it, with a warning for each old key.

    Example: tendond config migrate rig.toml --write
    """
    from tendond.cli.config.migrate import run_migrate

    run_migrate(file, write=write)


@config.command("schema")
def config_schema() -> None:
    """Print the JSON Schema, for completion in editors.

    Editors with taplo read it from a first line '#:schema ./tendond.schema.json' in the configuration.

    Example: tendond config schema > tendond.schema.json
    """
    from tendond.cli.config.check import run_schema

    run_schema()
