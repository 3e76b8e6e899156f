"""A thread beside a test."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def running(target: Callable[[], object], ending: threading.Event) -> Iterator[None]:
    """Run `target` in a thread until the end of the block, which sets `ending` and waits for it."""
    thread = threading.Thread(target=target)
    thread.start()
    try:
        yield
    finally:
        ending.set()
        thread.join()
