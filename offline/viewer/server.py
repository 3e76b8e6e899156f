"""Foxglove's WebSocket server, with a channel for each of a log's."""

from typing import Any

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import Channel


class Server:
    """A server that runs until `stop`.

    Args:
        channels: the channels that it offers.
        name: name of the rig.
        host: address to listen on.
        port: port to listen on; 0: a free one.

    Attributes:
        port: port that it listens on.

    Raises:
        UsageError: Foxglove's SDK is not installed, or the port is taken.
    """

    def __init__(self, channels: tuple[Channel[Any], ...], name: str, host: str, port: int) -> None:
        try:
            import foxglove as sdk
        except ImportError as error:
            raise UsageError("this needs Foxglove's SDK: pip install 'tendond[view]'") from error
        context = self._context = sdk.Context()  # its channels close with it
        try:
            self._server = sdk.start_server(name=f"tendond {name}", host=host, port=port, context=context)
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

    def stop(self) -> None:
        """Close the connections and stop listening."""
        self._server.stop()
