"""Progress of the compilation of kernels: a line each on a terminal; to a pipe, when it begins and ends."""

from collections.abc import Sequence

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from tendond.cli.common import say
from tendond.offline.kernels import TENDONS, compile_kernels


def compile_with_progress(parts: Sequence[Sequence[str]], tendons: int = TENDONS) -> None:
    """Compile what is not cached, see `compile_kernels`; silent where everything is.

    Raises:
        DaemonError: a process failed.
    """
    console = Console(stderr=True)
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    tasks: dict[str, TaskID] = {}
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:

        def show(name: str, count: int, function: str) -> None:
            if name not in tasks:
                tasks[name] = progress.add_task("")
                if not console.is_terminal:
                    say(f"compiling the kernels of the {name}: takes a minute or two, once")
            progress.update(tasks[name], description=f"compiling the kernels of the {name}: {count}, {function}")

        took = compile_kernels(parts, tendons, show)
    for name in tasks:
        say(f"kernels of the {name} compiled in {took[name]:.0f} s")
