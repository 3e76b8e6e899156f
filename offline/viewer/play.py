"""A log played to a viewer, which may hold it, jump in it, and change its speed."""

import time
from collections.abc import Iterator

from mcap.records import Message

from tendond.daemon.recording.channels import CHANNELS, CYCLE
from tendond.offline.logs.run import Run, no_cycles
from tendond.offline.viewer.playback import Playback
from tendond.offline.viewer.server import Server

PAUSE_SECONDS = 1.0
LOOK_BACK_NS = 2_000_000_000
"""Time before a jump's aim from which the newest message of each topic is shown at once: all but the configuration's
slowest shapes come more often."""

TIME_SECONDS = 1.0 / 60.0
"""Least time between two reports of the log's time: a screen's period."""

TOPICS = tuple(channel.topic for channel in CHANNELS if channel.topic != "state")


def time_range(run: Run) -> tuple[int, int]:
    """Return the times of the first and the last message that is played [ns].

    Raises:
        LogError: the log has no cycles.
    """
    if next(run.messages((CYCLE.topic,)), None) is None:
        raise no_cycles(run.paths[0])
    _, first = next(run.messages(TOPICS))
    return first.log_time, run.last_time() or max(message.log_time for _, message in run.messages(TOPICS))


def play(run: Run, server: Server, playback: Playback) -> None:
    """Play a log until the process is interrupted: in a loop, until a viewer takes control; then as it asks."""
    told = 0.0
    while True:
        for topic, message in _from(run, playback.take_jump()):
            if not playback.wait_until(message.log_time):
                break
            server.put(topic, message.data, message.log_time)
            if time.monotonic() >= told:
                told = time.monotonic() + TIME_SECONDS
                server.tell_time(message.log_time)
        else:
            if playback.controlled:
                server.tell_state(playback.end())
                playback.wait_for_jump()
            else:
                time.sleep(PAUSE_SECONDS)


def _from(run: Run, start_ns: int) -> Iterator[tuple[str, Message]]:
    """Yield the newest message of each topic before a time, then all from it on."""
    newest: dict[str, Message] = {}
    for topic, message in run.messages(TOPICS, start_ns - LOOK_BACK_NS):
        if message.log_time < start_ns:
            newest[topic] = message
            continue
        yield from newest.items()
        newest.clear()
        yield topic, message
    yield from newest.items()
