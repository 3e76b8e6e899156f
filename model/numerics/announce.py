"""Announce or report the compilation of kernels: it takes a minute, and happens once."""

from collections.abc import Callable

import numba.core.event as numba_events


class _FirstCompilation(numba_events.Listener):
    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self._said = False

    def on_start(self, event: numba_events.Event) -> None:
        if not self._said:
            self._said = True
            self._say("compiling the rod's kernels: takes a minute or two, on the first start only")

    def on_end(self, event: numba_events.Event) -> None:
        pass


def announce_compilation(say: Callable[[str], None]) -> None:
    """Call `say` with one line when the first kernel is compiled; never, when all of them come from the disk."""
    numba_events.register("numba:compile", _FirstCompilation(say))


class _EachCompilation(numba_events.Listener):
    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def on_start(self, event: numba_events.Event) -> None:
        pass

    def on_end(self, event: numba_events.Event) -> None:
        self._say(event.data["dispatcher"].py_func.__name__)


def report_compilation(say: Callable[[str], None]) -> None:
    """Call `say` with the name of each function that has been compiled."""
    numba_events.register("numba:compile", _EachCompilation(say))
