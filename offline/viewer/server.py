"""Foxglove's WebSocket server, with a channel for each of a log's."""

from typing import TYPE_CHECKING, Any

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import Channel
from tendond.offline.viewer.playback import Playback, Request, State

if TYPE_CHECKING:  # an extra
    from foxglove.websocket import PlaybackState


class Server:
    """A server that runs until `stop`.

    Args:
        channels: the channels that it offers.
        name: name of the rig.
        host: address to listen on.
        port: port to listen on; 0: a free one.
        playback: clock of the log that is played, which viewers then control; none for a live rig.

    Attributes:
        port: port that it listens on.

    Raises:
        UsageError: Foxglove's SDK is not installed, or the port is taken.
    """

    def __init__(
        self, channels: tuple[Channel[Any], ...], name: str, host: str, port: int, playback: Playback | None = None
    ) -> None:
        try:
            import foxglove as sdk
        except ImportError as error:
            raise UsageError("this needs Foxglove's SDK: pip install 'tendond[view]'") from error
        context = self._context = sdk.Context()  # its channels close with it
        played: dict[str, Any] = {}
        if playback is not None:
            played = {
                "capabilities": [sdk.websocket.Capability.Time, sdk.websocket.Capability.PlaybackControl],
                "playback_time_range": (playback.start_ns, playback.end_ns),
                "server_listener": _listener(playback),
            }
        try:
            self._server = sdk.start_server(name=f"tendond {name}", host=host, port=port, context=context, **played)
        except (OSError, RuntimeError) as error:
            raise UsageError(f"cannot serve at {host}:{port}: {error}; choose another with --port") from error
        self.port: int = self._server.port
        self._channels = {
            channel.topic: sdk.Channel(
                channel.topic,
                message_encoding="json",
                schema=sdk.Schema(name=channel.schema_name, encoding="jsonschema", data=channel.schema()),
                context=context,
            )
            for channel in channels
        }

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """Send a message to the viewers; topics without a channel are skipped."""
        if topic in self._channels:
            self._channels[topic].log(data, log_time=time_ns)

    def tell_time(self, time_ns: int) -> None:
        """Tell the viewers the log's time [ns]."""
        self._server.broadcast_time(time_ns)

    def tell_state(self, state: State) -> None:
        """Tell the viewers a state that none of them asked for."""
        self._server.broadcast_playback_state(_for_viewers(state))

    def stop(self) -> None:
        """Close the connections and stop listening."""
        self._server.stop()


def _listener(playback: Playback) -> Any:
    """Return what hands the viewers' requests to the clock; the SDK calls it from threads of its own."""
    from foxglove.websocket import PlaybackCommand, PlaybackControlRequest, PlaybackState, ServerListener

    class Listener(ServerListener):
        def on_playback_control_request(self, playback_control_request: PlaybackControlRequest) -> PlaybackState | None:
            asked = playback_control_request
            play = asked.playback_command == PlaybackCommand.Play
            state = playback.ask(Request(play, asked.playback_speed, asked.seek_time))
            return _for_viewers(state, did_seek=asked.seek_time is not None, request_id=asked.request_id)

    return Listener()


def _for_viewers(state: State, *, did_seek: bool = False, request_id: str | None = None) -> "PlaybackState":
    from foxglove.websocket import PlaybackState, PlaybackStatus

    still = PlaybackStatus.Ended if state.ended else PlaybackStatus.Paused
    return PlaybackState(
        status=PlaybackStatus.Playing if state.playing else still,
        current_time=state.now_ns,
        playback_speed=state.speed,
        did_seek=did_seek,
        request_id=request_id,
    )
