"""The command line: the groups of commands, and errors turned into lines and exit statuses."""

import os
import sys
import warnings
from io import TextIOWrapper
from typing import Annotated

import typer

from tendond import __version__
from tendond.cli.bench.commands import bench
from tendond.cli.bridge.commands import bridge
from tendond.cli.completion import begin_a_word_behind_equals
from tendond.cli.config.commands import config
from tendond.cli.demo.commands import demo
from tendond.cli.errors import say_error, status_of
from tendond.cli.identify.commands import identify
from tendond.cli.kernel_folder import prepare_for_numba
from tendond.cli.log.commands import log
from tendond.cli.log.kept_commands import LIBRARY
from tendond.cli.mocap.commands import mocap
from tendond.cli.program import Program
from tendond.cli.rig.commands import rig
from tendond.cli.servo.commands import servo
from tendond.cli.signals import INTERRUPTED, exit_at_the_end, exit_on_interrupt, was_interrupted
from tendond.cli.study.commands import study
from tendond.cli.study.control import control
from tendond.cli.study.safety import safety
from tendond.cli.study.stability import stability
from tendond.cli.trying.commands import try_rig
from tendond.cli.validate.commands import validate
from tendond.cli.warm.commands import warm
from tendond.schemas.config.renamed import RenamedKeyWarning

EPILOG = """\
\b
Exit status: 0 success; 1 refused or failed; 2 invalid usage or configuration;
130 interrupted. Results go to standard output, messages to standard error.
TENDOND_PROGRESS=off silences the progress of long work.
Run `tendond COMMAND --help` for details and an example.
"""

app = typer.Typer(
    name="tendond",
    cls=Program,
    help="Controller for tendon-driven continuum robots: Cosserat rod model, Zenoh bus, MCAP log of every cycle.",
    epilog=EPILOG,
    no_args_is_help=True,
    rich_markup_mode=None,  # the rich help page takes longer to import than all the rest of the program
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback(invoke_without_command=True)
def options(version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    """Handle the options of the program itself."""
    if version:
        print(f"tendond {__version__}")
        raise typer.Exit


for name, command in LIBRARY.items():
    log.command(name)(command)
study.add_typer(identify)
study.command("control")(control)
study.command("safety")(safety)
study.command("stability")(stability)
for group in (rig, mocap, log, servo, config, study, bench, bridge):
    app.add_typer(group)
app.command("try")(try_rig)
app.command()(demo)
app.command()(validate)
app.command()(warm)


def _show_renamed(message: Warning | str, *place: object, **more: object) -> None:
    """Print a warning as a line for people."""
    say_error(f"warning: {message}")


def main() -> None:
    """Run the command line; errors that a user can fix are one line each, without a traceback."""
    warnings.simplefilter("once", RenamedKeyWarning)
    warnings.showwarning = _show_renamed
    exit_on_interrupt()
    begin_a_word_behind_equals(os.environ)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a character that the terminal does not have is replaced
            stream.reconfigure(errors="replace" if stream is sys.stdout else "backslashreplace")
    try:
        prepare_for_numba(say_error)
        _run()
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
    finally:
        exit_at_the_end()


def _run() -> None:
    """Run the command; errors become lines and exit statuses."""
    try:
        try:
            status = app(prog_name="tendond", standalone_mode=False)  # not `python -m tendond`: what people type
        finally:
            sys.stdout.flush()
    except SystemExit as end:
        if not end.code and was_interrupted():
            raise SystemExit(INTERRUPTED) from None
        raise
    except Exception as error:
        if (failed := status_of(error)) is None:
            raise
        raise SystemExit(failed) from None
    if status:
        raise SystemExit(status)
    if was_interrupted():
        raise SystemExit(INTERRUPTED)
