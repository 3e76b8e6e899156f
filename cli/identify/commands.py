"""The commands that identify a rig: options and help; what they do stands in the modules that they import."""

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tendond.cli.options import Config, Yes
from tendond.cli.signals import leave_on_signals


class FitByDefault(TyperGroup):
    """A group of commands in which what names none of them is `fit`'s: `tendond identify LOG...`."""

    default = "fit"

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """As click's, with `fit` put in where it is meant."""
        if args and args[0] not in self.commands and args[0] not in ("-h", "--help"):
            args = [self.default, *args]
        return super().parse_args(ctx, args)


identify = typer.Typer(
    name="identify",
    cls=FitByDefault,
    help="Find the model's parameters from the rig's own logs.\n\nExample: tendond identify free.mcap weighted.mcap",
    no_args_is_help=True,
    rich_markup_mode=None,
)
Parts = Annotated[str, typer.Option("--parts", help="Of the excitation: sway, steps, chirp, with commas.")]
Reach = Annotated[float, typer.Option("--reach", min=0.5, max=1.0, help="Part of the way that the limits allow.")]
WeightOnTip = Annotated[float, typer.Option("--weight", min=0.0, max=10.0, help="Fixed to the tip [kg].")]
Jobs = Annotated[int | None, typer.Option("--jobs", "-j", min=1, max=1024, help="At once. Left out: one per core.")]
PARTS = "sway,steps,chirp"


@identify.command("fit")
def identify_fit(
    logs: Annotated[list[Path], typer.Argument(metavar="LOG...", help="To fit to, each from a rest on.")],
    parameters: Annotated[
        str | None,
        typer.Option(
            "--parameters",
            help="Names with commas. Left out: E,rho,Bbt,C,tendon_stiffness,tip_mass,delay,lag,spool,backlash.",
        ),
    ] = None,
    weight: Annotated[
        list[str] | None, typer.Option("--weight", help="LOG=KG fixed to the tip; before what the log says.")
    ] = None,
    hold_out: Annotated[
        list[Path] | None, typer.Option("--hold-out", help="Log to compare on and not to fit to; repeatable.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for parameter file, report and figures.")] = Path(
        "identified"
    ),
    drive: Annotated[
        str,
        typer.Option("--drive", help="Tendons' ends from the servos' reports or commands: auto, measured, command."),
    ] = "auto",
    load: Annotated[
        float | None, typer.Option("--load", min=0.01, help="Use the servos' tensions, right to this much [N].")
    ] = None,
    loss: Annotated[str, typer.Option("--loss", help="linear, soft_l1 or huber, for poses with outliers.")] = "linear",
    jobs: Jobs = None,
) -> None:
    """Fit parameters to logs; the word 'fit' may be left out.

    Leaves a dated file that a configuration takes in by 'include', a report, and figures. What the logs cannot tell is
    named and not reported. Interrupted, the same command goes on where it was.

    Example: tendond identify fit free.mcap weighted.mcap --weight weighted.mcap=0.05 --hold-out other.mcap
    """
    leave_on_signals(130)
    from tendond.cli.identify.fit import run_fit

    run_fit(logs, parameters, weight or [], hold_out or [], out, drive, load, loss, jobs)


@identify.command("plan")
def identify_plan(config: Config = None, parts: Parts = PARTS, reach: Reach = 1.0) -> None:
    """Propose a safe excitation, and a weight.

    It is tried on the simulator of this configuration first.

    Example: tendond identify plan --config rig.toml
    """
    leave_on_signals(130)
    from tendond.cli.identify.fit import show_plan

    show_plan(config, parts, reach)


@identify.command("run")
def identify_run(
    config: Config = None,
    log: Annotated[
        Path | None,
        typer.Option("--log", help="MCAP file to write, a new one. Left out: log/RIG-identify-TIME.mcap."),
    ] = None,
    parts: Parts = PARTS,
    reach: Reach = 1.0,
    weight: WeightOnTip = 0.0,
    yes: Yes = False,
) -> None:
    """Carry out the excitation on the rig, and record it.

    Starts a controller of its own, so no other one may run; camera and servos (or 'tendond simulate') connect to it.
    The arm moves. Ctrl-C releases it.

    Example: tendond identify run --config rig.toml --log weighted.mcap --parts steps --reach 0.6 --weight 0.05
    """
    leave_on_signals(130)
    from tendond.cli.identify.run import run_plan

    run_plan(config, log, parts, reach, weight, yes=yes)


@identify.command("demo")
def identify_demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for logs, parameter files and summary.")] = Path(
        "out/identify"
    ),
    seeds: Annotated[
        int, typer.Option("--seeds", min=0, max=1000, help="Fits to other noise, to count how often errors are right.")
    ] = 0,
    jobs: Jobs = None,
) -> None:
    """Prove it on simulated rigs whose parameters are known.

    Takes about a minute on two idle cores; with --seeds 50 ten minutes more.

    Example: tendond identify demo --seeds 50
    """
    leave_on_signals(130)
    from tendond.cli.identify.demo import run_identify_demo

    run_identify_demo(out, seeds, jobs)


def add_to(app: typer.Typer) -> None:
    """Add the commands of this module."""
    app.add_typer(identify)
