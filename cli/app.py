"""The command line: the commands of the modules beside this one, and what becomes of errors."""

import os
import sys
import warnings
from io import TextIOWrapper
from typing import Annotated

import typer

from tendond import TendondError, __version__
from tendond.cli.bench import commands as bench_commands
from tendond.cli.config import commands as config_commands
from tendond.cli.identify import commands as identify_commands
from tendond.cli.kernel_folder import NOWHERE, prepare_for_numba
from tendond.cli.log import commands as log_commands
from tendond.cli.rig import doctor_commands, operator_commands, process_commands
from tendond.cli.servo import commands as servo_commands
from tendond.cli.signals import INTERRUPTED, leave_at_the_end, leave_on_interrupt, was_interrupted
from tendond.cli.study import commands as study_commands
from tendond.cli.study import experiment_commands
from tendond.schemas.config.renamed import RenamedKeyWarning

EPILOG = """\
\b
Exit status: 0 done; 1 refused or failed, said in a line; 2 wrong usage or
configuration; 130 interrupted. Results go to standard output, the rest to
standard error. Each command tells of itself with --help, with an example.
"""

app = typer.Typer(
    name="tendond",
    help="Controller for tendon-driven continuum robots: Cosserat rod model, Zenoh bus, MCAP log of every cycle.",
    epilog=EPILOG,
    no_args_is_help=True,
    rich_markup_mode=None,  # the rich help page takes longer to import than all the rest of the program
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

EXIT_FAILED = 1
EXIT_USAGE = 2


@app.callback(invoke_without_command=True)
def options(version: Annotated[bool, typer.Option("--version", help="Print the version and leave.")] = False) -> None:
    """Options of the program itself."""
    if version:
        print(f"tendond {__version__}")
        raise typer.Exit


for commands in (
    process_commands,
    servo_commands,
    operator_commands,
    config_commands,
    doctor_commands,
    experiment_commands,
    study_commands,
    bench_commands,
    log_commands,
    identify_commands,
):
    commands.add_to(app)


def _show_renamed(message: Warning | str, *place: object, **more: object) -> None:
    """Print a warning as a line for people."""
    print(f"tendond: warning: {message}", file=sys.stderr, flush=True)


def main() -> None:
    """Run the command line; what a user can mend is one line each and no traceback."""
    warnings.simplefilter("once", RenamedKeyWarning)
    warnings.showwarning = _show_renamed
    leave_on_interrupt()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):  # a character that the terminal does not have is replaced
            stream.reconfigure(errors="replace" if stream is sys.stdout else "backslashreplace")
    try:
        prepare_for_numba(_say)
        _run()
    except KeyboardInterrupt:
        raise SystemExit(INTERRUPTED) from None
    finally:
        leave_at_the_end()


def _run() -> None:
    """Run the command; errors become lines and exit statuses."""
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except SystemExit as end:
        if not end.code and was_interrupted():
            raise SystemExit(INTERRUPTED) from None
        raise
    except TendondError as error:
        for line in str(error).splitlines():
            _say(line)
        raise SystemExit(_exit_code(error)) from None
    except BrokenPipeError:  # as in `tendond config show | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the interpreter tries once more at its end
        raise SystemExit(EXIT_FAILED) from None
    except OSError as error:
        if error.filename is None:
            raise
        _say(f"{error.filename}: {error.strerror}")
        raise SystemExit(EXIT_FAILED) from None
    except RuntimeError as error:
        if "cannot cache function" not in str(error):  # numba's, when a kernel is imported
            raise
        _say(NOWHERE)
        raise SystemExit(EXIT_FAILED) from None


def _say(line: str) -> None:
    print(f"tendond: {line}", file=sys.stderr, flush=True)


def _exit_code(error: TendondError) -> int:
    from tendond.daemon.errors import UsageError
    from tendond.schemas.config.rig import ConfigError

    return EXIT_USAGE if isinstance(error, (ConfigError, UsageError)) else EXIT_FAILED
