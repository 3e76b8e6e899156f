"""`tendond log view`: a Foxglove WebSocket server, fed from Zenoh or from a log."""

from pathlib import Path

from tendond.cli.common import load_config, say
from tendond.daemon.recording.channels import CHANNELS
from tendond.offline.logs.run import open_run
from tendond.offline.viewer.play import play, time_range
from tendond.offline.viewer.playback import Playback
from tendond.offline.viewer.relay import LIVE, relay
from tendond.offline.viewer.server import Server


def run_view(file: Path | None, config: Path | None, host: str, port: int) -> None:
    """Serve until a signal comes; see `tendond log view --help`.

    Raises:
        TendondError: the extra is missing, the port is taken, the log cannot be used, or there is no controller.
    """
    run = None if file is None else open_run(file)
    playback = None if run is None else Playback(*time_range(run))
    rig = load_config(config) if run is None else run.config
    server = Server(CHANNELS if run is not None else LIVE, rig.rig.name, host, port, playback)
    try:
        say(f"serving {run.paths[0] if run else f'rig {rig.rig.name!r}'} at ws://{host}:{server.port}")
        if run is not None and playback is not None:
            play(run, server, playback)
        else:
            relay(rig, server)
    finally:
        server.stop()
