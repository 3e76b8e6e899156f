"""`tendond validate`: options and help."""

from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.completion import datasets
from tendond.cli.options import Json
from tendond.cli.signals import exit_on_signals


def validate(
    dataset: Annotated[
        str | None,
        typer.Argument(
            metavar="DATASET", help="Name, or a CSV file, see below.", autocompletion=datasets, show_default=False
        ),
    ] = None,
    data: Annotated[
        str, typer.Option("--data", metavar="DIR", help="Folder of public data. Default: $TENDOND_REFERENCE_DATA.")
    ] = "",
    parameters: Annotated[
        str | None,
        typer.Option(
            "--parameters", help="Groups of parameters, comma-separated, or auto. Default: the data set's, or auto."
        ),
    ] = None,
    residual: Annotated[
        bool, typer.Option("--residual", help="Train a bounded correction of the rod as well.")
    ] = False,
    poses: Annotated[
        int | None,
        typer.Option(
            "--poses",
            min=20,
            max=1_000_000,
            help="Poses that a fit goes through, about. Default: the data set's, or 600.",
        ),
    ] = None,
    every: Annotated[
        int | None,
        typer.Option(
            "--every", min=2, max=1000, help="Hold out one block in so many, instead of the data set's own part."
        ),
    ] = None,
    length: Annotated[
        float | None, typer.Option("--length", min=0.0, max=10.0, help="Backbone of a CSV file's robot [m].")
    ] = None,
    radius: Annotated[
        float | None, typer.Option("--radius", min=0.0, max=1.0, help="Its tendons' distance from the axis [m].")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="Folder for report, figure, JSON, correction. Default: none written.")
    ] = None,
    json: Json = False,
) -> None:
    """Fit the general rod to a measured robot, and test it.

    DATASET: armlab, ftdcr_v4-tendon_pull, ftdcr_v4-val, ftdcr_v6-val, from others' repositories (docs/evidence.md), or
    a CSV file with columns displacement_0, displacement_1, ..., x, y, z [m] and, if wanted, block, in the order of
    measurement. Its robot is one straight section on the camera's +z, its tendons at equal angles from +x, sizes by
    --length and --radius.

    Whole blocks of the sequence are held out: of ftdcr_v4-val the authors' validation file, whose kinds of motion the
    training part lacks; --every 4 holds out some of every kind. Beside the rod: constant curvature, a polynomial, the
    rod without friction. auto adds groups of parameters while the Bayesian information criterion on the training part
    falls; it takes many minutes.

    Exit status 1: the data are missing, or a data set's target is missed.

    Example: tendond validate ftdcr_v4-tendon_pull --out out/evidence
    """
    exit_on_signals(130)
    from tendond.cli.validate.run import run_validate
    from tendond.daemon.errors import UsageError

    if dataset is None:
        raise UsageError(f"DATASET is missing: name {', '.join(datasets())}, or a CSV file")

    groups = None if parameters is None else tuple(one.strip() for one in parameters.split(",") if one.strip())
    if not run_validate(
        dataset,
        data,
        groups,
        residual=residual,
        count=poses,
        every=every,
        length=length,
        radius=radius,
        out=out,
        as_json=json,
    ):
        raise typer.Exit(1)
