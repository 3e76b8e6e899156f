"""The group `tendond mocap`: options and help."""

from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from tendond.cli.options import Config
from tendond.cli.signals import exit_on_signals


class RunByDefault(TyperGroup):
    """Group of commands with a default, `run`: `tendond mocap --config FILE`."""

    default = "run"

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Insert `run` where no command is named."""
        if not args or (args[0].startswith("-") and args[0] not in ("-h", "--help")):
            args = [self.default, *args]
        return super().parse_args(ctx, args)


mocap = typer.Typer(
    name="mocap",
    cls=RunByDefault,
    help="Publish tip poses from cameras; calibrate a webcam.\n\nExample: tendond mocap --config rig.toml",
    rich_markup_mode=None,
)


@mocap.command("run")
def mocap_run(config: Config = None) -> None:
    """Publish tip poses from cameras.

    The system is that of [mocap]: Vicon, OptiTrack, Qualisys, VRPN, or AprilTags on a webcam. `run` may be left out.
    Runs until Ctrl-C or SIGTERM.

    Example: tendond mocap run --config rig.toml
    """
    exit_on_signals()
    from tendond.cli.rig.cameras import run_cameras

    run_cameras(config, "mocap")


@mocap.command("calibrate")
def mocap_calibrate(
    sources: Annotated[
        list[str],
        typer.Argument(metavar="SOURCE...", help="Pictures, folders of them, a video file, or a device (/dev/video0)."),
    ],
    square: Annotated[float, typer.Option("--square", min=1e-4, max=1.0, help="Side of a square of the board [m].")],
    columns: Annotated[int, typer.Option("--columns", min=3, max=50, help="Inner corners of the board in a row.")] = 9,
    rows: Annotated[int, typer.Option("--rows", min=3, max=50, help="Inner corners of the board in a column.")] = 6,
    views: Annotated[int, typer.Option("--views", min=8, max=200, help="Distinct views to use at most.")] = 30,
    out: Annotated[Path, typer.Option("--out", help="File to write.")] = Path("camera.toml"),
) -> None:
    """Calibrate a webcam from views of a chessboard.

    Writes its intrinsics for mocap.apriltag.calibration. Refuses too few or too similar views.

    Examples: tendond mocap calibrate pictures/ --square 0.025; tendond mocap calibrate /dev/video0 --square 0.025
    """
    exit_on_signals()
    from tendond.cli.extras import need

    need("cv2")
    from tendond.cli.mocap.calibrate import run_calibrate

    run_calibrate(sources, out, board=(columns, rows), square=square, views_max=views)
