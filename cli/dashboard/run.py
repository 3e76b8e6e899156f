"""`tendond dashboard`: the page's server beside a thread that follows the rig; a client of the bus as `watch` is."""

import asyncio
import json
import logging
import os
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tendond.cli.common import load_config, say
from tendond.cli.extras import need
from tendond.cli.rig.operator import option_of
from tendond.daemon.errors import UsageError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import CONFIG_VARIABLE

POLL_SECONDS = 0.1


def run_dashboard(config_file: Path | None, host: str, port: int, stopped: Callable[[], bool]) -> None:
    """Serve the page until a signal comes; see `tendond dashboard --help`.

    Args:
        config_file: the rig's configuration file.
        host, port: address to listen on.
        stopped: true when the process is to end.

    Raises:
        ModuleNotFoundError: the extra is missing.
        TendondError: the configuration or the address cannot be used.
    """
    config = load_config(config_file).with_own_rates()
    need("tornado")
    asyncio.run(_serve(config, option_of(config_file), host, port, stopped))


async def _serve(config: RigConfig, option: str, host: str, port: int, stopped: Callable[[], bool]) -> None:
    """Serve, and follow the rig in a thread.

    Raises:
        UsageError: the address cannot be used.
    """
    from tendond.cli.dashboard.access import Access
    from tendond.cli.dashboard.live import Live
    from tendond.cli.dashboard.operator import Operator
    from tendond.cli.dashboard.server import Hub, serve

    logging.getLogger("tornado").setLevel(logging.CRITICAL)  # requests that others send wrongly are none of our faults
    loop = asyncio.get_running_loop()
    access = Access.of(host, guarded=CONFIG_VARIABLE in os.environ)
    operator = Operator(config, option)
    hub = Hub(access, operator.carry_out, json.dumps({"welcome": welcome(config)}))
    try:
        server, used = serve(hub, host, port)
    except OSError as error:
        raise UsageError(f"cannot serve at {host}:{port}: {error.strerror}; choose another with --port") from error
    ended, failed = threading.Event(), loop.create_future()

    def send(frame: str) -> None:
        loop.call_soon_threadsafe(hub.show, frame)

    def returned() -> None:
        threading.Thread(target=operator.reconnect, daemon=True, name="reconnect").start()

    def follow() -> None:
        try:
            Live(config, option, send, returned).run(ended)
        except Exception as error:
            loop.call_soon_threadsafe(failed.set_exception, error)

    thread = threading.Thread(target=follow, daemon=True, name="live")
    thread.start()
    token = f"#token={access.token}" if access.token else ""
    say(f"rig '{config.rig.name}' at http://{_address(host)}:{used}/{token}")
    try:
        while not stopped() and not failed.done():
            await asyncio.sleep(POLL_SECONDS)
        if failed.done():
            await failed
    finally:
        server.stop()
        ended.set()
        await asyncio.to_thread(thread.join, 1.0)
        operator.close()


def _address(host: str) -> str:
    """Return what to open in the browser for an address to listen on; for all of them, this computer's name."""
    if host in ("", "0.0.0.0", "::"):
        return socket.gethostname()
    if host == "127.0.0.1":
        return "localhost"
    return f"[{host}]" if ":" in host else host


def welcome(config: RigConfig) -> dict[str, Any]:
    """Return what the page knows of the rig before its first frame."""
    from tendond.cli.teleop.run import speed_max
    from tendond.daemon.control.laws.registry import LAWS
    from tendond.schemas.config.reference import TARGETS, ReferenceSection

    kinds = ReferenceSection.model_json_schema()["properties"]["kind"]["enum"]
    return {
        "rig": config.rig.name,
        "endpoint": config.bus.endpoint,
        "laws": list(LAWS),
        "kinds": kinds,
        "targets": TARGETS,
        "reference": config.reference.model_dump(exclude_defaults=True, exclude={"samples", "waypoints", "file"}),
        "length": config.rod.backbone_length,
        "gravity": config.rod.gravity,
        "speed_max": speed_max(config),
        "displacement_min": config.limits.displacement_min,
        "displacement_max": config.limits.displacement_max,
    }
