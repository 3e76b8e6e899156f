"""Files of figures: names by log and run, one a format, none replaced unless asked for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from tendond.daemon.errors import DaemonError
from tendond.offline.parallel import in_parallel
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.style import place_parts, style, write


@dataclass(frozen=True)
class Named:
    """A figure that is still to be drawn: what its file is called, and how to draw it."""

    name: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Output:
    """Folder into which the figures of a log go, and the names of their files.

    Attributes:
        folder: made when needed.
        prefix: beginning of each name: the log's, with the number of the run.
        force: replace files that exist.
    """

    folder: Path
    prefix: str = ""
    force: bool = True

    def paths(self, name: str) -> list[Path]:
        """Return the files of a figure, one a format."""
        return [self.folder / f"{self.prefix}{name}.{form}" for form in appearance().formats]

    def check(self, names: Sequence[str]) -> None:
        """Check that no file of these figures exists.

        Raises:
            DaemonError: one does, and is not to be replaced.
        """
        check_new([path for name in names for path in self.paths(name)], force=self.force)

    def draw(self, figures: Sequence[Named]) -> list[Path]:
        """Draw figures and save them, on two processors; return the files in order.

        Raises:
            DaemonError: a file exists already. OSError: one cannot be written.
        """
        jobs = [partial(self._draw, one) for one in figures]
        return [path for paths in in_parallel(jobs) for path in paths]

    def _draw(self, one: Named) -> list[Path]:
        with style():
            return self.save(one.draw(), one.name)

    def save(self, figure: Figure, name: str) -> list[Path]:
        """Save a figure in each format of the appearance in use.

        Raises:
            DaemonError: a file exists already. OSError: one cannot be written.
        """
        self.check([name])
        self.folder.mkdir(parents=True, exist_ok=True)
        with style():
            place_parts(figure)
            for path in self.paths(name):
                write(figure, path)
        return self.paths(name)


def check_new(paths: Sequence[Path], *, force: bool) -> None:
    """Check that no file exists.

    Raises:
        DaemonError: one does, and is not to be replaced.
    """
    for path in paths:
        if not force and path.exists():
            raise DaemonError(f"{path}: exists already; --force replaces it, --out takes another place")
