"""The group `tendond identify`: options and help."""

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tendond.cli.completion import logs as completed_logs
from tendond.cli.options import Config, Jobs, Yes
from tendond.cli.signals import exit_on_signals


class FitByDefault(TyperGroup):
    """Group of commands with a default, `fit`: `tendond identify LOG...`."""

    default = "fit"

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert `fit` where no command is named."""
        if args and args[0] not in self.commands and args[0] not in ("-h", "--help"):
            args = [self.default, *args]
        return super().parse_args(ctx, args)


identify = typer.Typer(
    name="identify",
    cls=FitByDefault,
    help="Identify the model's parameters from logs.\n\nExample: tendond identify free.mcap weighted.mcap",
    no_args_is_help=True,
    rich_markup_mode=None,
)
Parts = Annotated[str, typer.Option("--parts", help="Parts of the excitation: sway, steps, chirp; comma-separated.")]
Reach = Annotated[float, typer.Option("--reach", min=0.5, max=1.0, help="Fraction of the range that the limits allow.")]
WeightOnTip = Annotated[float, typer.Option("--weight", min=0.0, max=10.0, help="Mass fixed to the tip [kg].")]
PARTS = "sway,steps,chirp"


@identify.command("fit")
def identify_fit(
    logs: Annotated[
        list[Path],
        typer.Argument(metavar="LOG...", help="Logs to fit, each starting at rest.", autocompletion=completed_logs),
    ],
    parameters: Annotated[
        str | None,
        typer.Option(
            "--parameters",
            help="Comma-separated names, or auto: what the logs support. Default: E,rho,Bbt,C,tendon_stiffness,"
            "tip_mass,delay,lag,spool,backlash. Others: zero, zeros, mu, radius, radii, precurvature, tip_offset, "
            "base_position, base_rotation, base.",
        ),
    ] = None,
    weight: Annotated[
        list[str] | None, typer.Option("--weight", help="LOG=KG, mass fixed to the tip; overrides the log's own value.")
    ] = None,
    hold_out: Annotated[
        list[Path] | None, typer.Option("--hold-out", help="Log to validate on, not fitted; may be repeated.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for parameter file, report and figures.")] = Path(
        "identified"
    ),
    drive: Annotated[
        str,
        typer.Option("--drive", help="Tendon displacements to use: auto, measured (by the servos) or command."),
    ] = "auto",
    load: Annotated[
        float | None,
        typer.Option("--load", min=0.01, help="Use the servos' tensions, correct to this much [N]."),
    ] = None,
    loss: Annotated[str, typer.Option("--loss", help="linear; soft_l1 or huber for poses with outliers.")] = "linear",
    residual: Annotated[
        bool,
        typer.Option("--residual", help="Learn a bounded correction of what the fit leaves, as [observer.residual]."),
    ] = False,
    statics: Annotated[
        bool | None,
        typer.Option(
            "--statics/--motion",
            help="Fit the rests, or the motion. Default: the rests where the logs wait more than they move.",
            show_default=False,
        ),
    ] = None,
    prior: Annotated[
        list[str] | None,
        typer.Option(
            "--prior", help="KEY=VALUE+-SIGMA, what is known of a parameter, or a TOML file of KEY = [VALUE, SIGMA]."
        ),
    ] = None,
    jobs: Jobs = None,
) -> None:
    """Fit parameters to logs; the word 'fit' is optional.

    Writes a parameter file for a configuration's 'include', a report and figures. Parameters that the logs do not
    identify are listed without a value. An interrupted fit can be resumed with the same command.

    Example: tendond identify fit free.mcap weighted.mcap --weight weighted.mcap=0.05 --hold-out other.mcap
    """
    exit_on_signals(130)
    from tendond.cli.identify.fit import run_fit

    run_fit(
        logs, parameters, weight or [], hold_out or [], out, drive, load, loss, jobs, statics, prior or [],
        residual=residual,
    )  # fmt: skip


@identify.command("plan")
def identify_plan(config: Config = None, parts: Parts = PARTS, reach: Reach = 1.0) -> None:
    """Propose a safe excitation and a tip mass.

    The plan is simulated with this configuration first.

    Example: tendond identify plan --config rig.toml
    """
    exit_on_signals(130)
    from tendond.cli.identify.fit import show_plan

    show_plan(config, parts, reach)


@identify.command("run")
def identify_run(
    config: Config = None,
    log: Annotated[
        Path | None,
        typer.Option("--log", help="New MCAP file to write. Default: log/RIG-identify-TIME.mcap."),
    ] = None,
    parts: Parts = PARTS,
    reach: Reach = 1.0,
    weight: WeightOnTip = 0.0,
    yes: Yes = False,
) -> None:
    """Run the excitation on the rig and record it.

    Starts its own controller, so no other may run; camera and servos (or 'tendond simulate') connect to it. The arm
    moves. Ctrl-C releases the tendons.

    Example: tendond identify run --config rig.toml --log weighted.mcap --parts steps --reach 0.6 --weight 0.05
    """
    exit_on_signals(130)
    from tendond.cli.identify.run import run_plan

    run_plan(config, log, parts, reach, weight, yes=yes)


@identify.command("demo")
def identify_demo(
    out: Annotated[Path, typer.Option("--out", help="Folder for logs, parameter files and summary.")] = Path(
        "out/identify"
    ),
    seeds: Annotated[
        int, typer.Option("--seeds", min=0, max=1000, help="Repetitions with other noise, to check the stated errors.")
    ] = 0,
    jobs: Jobs = None,
) -> None:
    """Validate identification on simulated rigs.

    Their parameters are known. Takes about a minute on two idle cores; with --seeds 50 ten minutes more.

    Example: tendond identify demo --seeds 50
    """
    exit_on_signals(130)
    from tendond.cli.identify.demo import run_identify_demo

    run_identify_demo(out, seeds, jobs)
