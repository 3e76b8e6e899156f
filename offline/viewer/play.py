"""A log played to a viewer."""

import time

from tendond.daemon.recording.channels import CHANNELS, CYCLE
from tendond.offline.logs.run import Run, no_cycles
from tendond.offline.viewer.server import Server

PAUSE_SECONDS = 1.0


def check_playable(run: Run) -> None:
    """Check that a log has cycles to play.

    Raises:
        LogError: it has none.
    """
    if next(run.messages((CYCLE.topic,)), None) is None:
        raise no_cycles(run.paths[0])


def play(run: Run, server: Server) -> None:
    """Play a log at the speed of its recording, in a loop, until the process is interrupted."""
    topics = [channel.topic for channel in CHANNELS if channel.topic != "state"]
    while True:
        offset_ns: int | None = None
        for topic, message in run.messages(topics):
            now_ns = time.monotonic_ns()
            offset_ns = now_ns - message.log_time if offset_ns is None else offset_ns
            time.sleep(max(0, message.log_time + offset_ns - now_ns) / 1e9)
            server.put(topic, message.data, message.log_time)
        time.sleep(PAUSE_SECONDS)
