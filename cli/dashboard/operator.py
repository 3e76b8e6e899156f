"""Requests of the page: checked, made into those of an operator, and sent to the controller.

The bus has one session for stops and another for everything else, and each request waits in a thread of its own: none
can hold up a stop.
"""

import threading
import time
from contextlib import suppress
from typing import Any

import zenoh

from tendond import TendondError
from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask, ask_status
from tendond.cli.rig.operator import reference_request
from tendond.cli.rig.tuning import parsed
from tendond.cli.teleop.run import Stream, speed_max
from tendond.daemon.errors import UsageError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.remedies import clearing, sentence
from tendond.schemas.requests import ControlAction, ControlReply, ControlRequest

FRESH_SECONDS, FRESH_JOG_SECONDS = 3.0, 0.3
"""Age of the newest frame that a page had when it asked, beyond which its request is refused: a network, or a phone
that slept, may deliver it late. A speed by hand has that of `teleop.timeout`."""

CONNECT_SECONDS = 1.0
WAIT_SECONDS = 0.5
"""Time that the end of a motion by hand waits for the request before it [s]."""

KEYS, KEY_LENGTH = 16, 128
"""Settings of a request that are read, and their length: those that `ControlRequest` takes."""

Asked = dict[str, Any]


def request_of(asked: Asked, config: RigConfig) -> ControlRequest:
    """Make a page's wish into a request; the controller checks it again.

    Args:
        asked: `do`, an action; with `law`: its name; with `reference` or `set`: `settings`, a list of KEY=VALUE.
        config: of the rig.

    Raises:
        UsageError: it is none.
    """
    action, settings = asked.get("do"), asked.get("settings")
    if action in ("arm", "stop", "reset"):
        return ControlRequest(action=ControlAction(action))
    if action == "law" and isinstance(name := asked.get("law"), str):
        return ControlRequest(action=ControlAction.LAW, law=name[:64])
    if isinstance(settings, list) and settings and all(isinstance(one, str) for one in settings):
        if action == "reference":
            return reference_request(settings, config, files=False)
        if action == "set":
            values = dict(parsed(one[:KEY_LENGTH]) for one in settings[:KEYS])
            return ControlRequest(action=ControlAction.SET, settings=values)
    raise UsageError(f"'{str(action)[:32]}': no such request, or not with this")


def late(asked: Asked, now: float) -> str:
    """Return why a wish comes too late to be carried out, in words; empty for one that does not, and for every stop.

    Args:
        asked: with `now`, that of the newest frame that the page had.
        now: monotonic time [s].
    """
    if asked.get("do") == "stop":
        return ""
    seen = asked.get("now")
    if not isinstance(seen, int | float) or isinstance(seen, bool):
        return "the page had not shown the rig yet"
    limit = FRESH_JOG_SECONDS if asked.get("do") == "jog" else FRESH_SECONDS
    return f"not done: the page was {now - seen:.1f} s behind" if not 0.0 <= now - seen <= limit else ""


class Connection:
    """A session that is opened again where its controller is gone."""

    def __init__(self, config: RigConfig) -> None:
        self._endpoint, self._rig = config.bus.endpoint, config.rig.name
        self._opening = threading.Lock()
        self._session: zenoh.Session | None = None

    def session(self) -> zenoh.Session:
        """Return the open session.

        Raises:
            BusError: there is no controller.
        """
        with self._opening:
            if self._session is None or self._session.is_closed():
                self._session = open_client(self._endpoint, CONNECT_SECONDS)
            return self._session

    def ask(self, wanted: ControlRequest) -> ControlReply:
        """Send a request and wait for the reply.

        Raises:
            BusError: there is none.
        """
        try:
            return ask(self.session(), self._rig, wanted)
        except zenoh.ZError as error:
            raise BusError(f"no connection to the controller of rig '{self._rig}'") from error

    def close(self) -> None:
        """Close the session; the next request opens one."""
        with self._opening:
            session, self._session = self._session, None
        if session is not None:
            with suppress(zenoh.ZError):
                session.close()


class Operator:
    """Sender of the page's requests; each call waits, and may be made on any thread.

    Args:
        config: of the rig.
        option: that names it, in commands.
    """

    def __init__(self, config: RigConfig, option: str) -> None:
        self._config, self._option = config, option
        self._stops, self._others = Connection(config), Connection(config)
        self._stream: Stream | None = None
        self._jogging = threading.Lock()

    def reconnect(self) -> None:
        """Open both sessions anew: the controller is new, or back."""
        self._stream = None
        for connection in (self._stops, self._others):
            connection.close()
            with suppress(TendondError):
                connection.session()

    def carry_out(self, asked: Asked) -> tuple[bool, str]:
        """Send a wish to the controller; return whether it was done, and the reply as a sentence."""
        if reason := late(asked, time.monotonic()):
            return False, reason
        try:
            if asked.get("do") == "jog":
                return self._jog(asked.get("part"))
            wanted = request_of(asked, self._config)
            connection = self._stops if wanted.action is ControlAction.STOP else self._others
            return self._in_words(connection.ask(wanted))
        except TendondError as error:
            return False, str(error)

    def close(self) -> None:
        """Close the sessions."""
        self._stops.close()
        self._others.close()

    def _jog(self, part: object) -> tuple[bool, str]:
        """Ask for a part of the largest speed, from -1 to 1; left out while the one before still waits."""
        if not isinstance(part, int | float) or isinstance(part, bool) or not -1.0 <= part <= 1.0:
            raise UsageError("by hand: a part of the largest speed, from -1 to 1")
        if not self._jogging.acquire(
            timeout=WAIT_SECONDS if part == 0.0 else 0.0
        ):  # what ends the motion is not left out
            return True, "moving"
        try:
            if self._stream is None:
                session = self._others.session()
                self._stream = Stream(session, self._config.rig.name, ask_status(session, self._config.rig.name))
            return self._in_words(self._stream.send(part * speed_max(self._config)))
        except (BusError, zenoh.ZError) as error:
            self._stream = None
            return False, str(error)
        finally:
            self._jogging.release()

    def _in_words(self, reply: ControlReply) -> tuple[bool, str]:
        status = reply.status
        if status is None:
            return reply.done, reply.message
        to_clear = ""
        if status.mode is Mode.FAULT:
            to_clear = clearing(status.reason, self._option, has_servos=self._config.servo is not None)
        return reply.done, sentence(reply.message, status.mode, to_clear, self._option)
