"""`tendond bench plants`: the simulator's own plant beside the one in MuJoCo."""

import json
from dataclasses import asdict
from pathlib import Path

import typer

from tendond.cli.options import Config, Json, Profile
from tendond.cli.signals import exit_on_signals


def plants(config: Config = None, profile: Profile = None, as_json: Json = False) -> None:
    """Compare the simulator's plant with the one in MuJoCo.

    The configured robot as both: where its tip rests at several tensions, its first frequencies of bending, and the
    closed loop on both, in lockstep; half a minute. Needs the extra mujoco. Exit status 1: a row misses its goal.

    Example: tendond bench plants --config rig.toml
    """
    exit_on_signals(130)
    if not run_plants(config, profile, as_json=as_json):
        raise typer.Exit(1)


def run_plants(config_file: Path | None, profile: str | None, *, as_json: bool) -> bool:
    """Print the table; return whether every row meets its goal.

    Raises:
        TendondError: the configuration cannot be used, a plant cannot be that robot, or a run does not track.
    """
    from tendond.cli.common import chosen_config, say
    from tendond.cli.extras import need
    from tendond.model.numerics.announce import announce_compilation
    from tendond.offline.progress import working

    need("mujoco")
    from tendond.offline.bench.plants import compare

    config, _ = chosen_config(config_file, profile)
    announce_compilation(say)
    with working("comparing the plants"):
        rows = list(compare(config))
    if as_json:
        print(json.dumps([asdict(row) for row in rows], indent=2))
        return all(row.meets for row in rows)
    print("| quantity | unit | own plant | MuJoCo | apart |")
    print("| --- | --- | --- | --- | --- |")
    for row in rows:
        own, other, apart = ("-" if one is None else f"{one:.2f}" for one in (row.own, row.mujoco, row.apart))
        print(f"| {row.quantity} | {row.unit} | {own} | {other} | {apart}{'' if row.meets else ' (misses its goal)'} |")
    return all(row.meets for row in rows)
