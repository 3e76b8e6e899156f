"""Foxglove's WebSocket server, fed from a log or from Zenoh."""
