"""Driver of Vicon in a thread, and a listener to its poses."""

import math
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zenoh

from tendond.daemon.runtime.bus import Hub
from tendond.drivers.host import Host
from tendond.drivers.mocap.process import MocapDriver
from tendond.drivers.vicon.packet import ObjectReading
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose
from tendond.schemas.wire import decode
from tests.rig.tracker import BASE, TIP, Tracker, free_port

PATIENCE_SECONDS = 60.0


MARK = ObjectReading((500.0, 500.0, 500.0), (0.0, 0.0, 0.0))


class Listener:
    """Running driver, its poses and its lines for people."""

    def __init__(self, config: RigConfig, session: zenoh.Session) -> None:
        assert config.cameras is not None
        self.config, self.section = config, config.cameras
        self.said: list[str] = []
        self.poses: list[TipPose] = []
        self._subscriber = session.declare_subscriber(key(config.rig.name, TIP_POSE), zenoh.handlers.FifoChannel(10000))

    def until(self, wanted: Callable[["Listener"], bool], prod: Callable[[], None] = lambda: None) -> None:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not wanted(self):
            assert time.monotonic() < deadline, (self.said, self.poses[-3:])
            prod()
            time.sleep(0.005)
            while (sample := self._subscriber.try_recv()) is not None:
                self.poses.append(decode(TipPose, sample.payload.to_bytes()))

    def heard(self, tracker: Tracker) -> None:
        """Send frames until the driver receives them; forget the poses so far."""
        self.until(lambda one: bool(one.poses), lambda: tracker.send({"tip": TIP, "base": BASE}))
        tracker.send({"tip": MARK, "base": BASE})
        marked = self.poses[0].position
        self.until(lambda one: one.poses[-1].position != marked)
        self.poses.clear()


@contextmanager
def driver(**section: Any) -> Iterator[tuple[Listener, Tracker]]:
    """Run a driver in a thread; by default the base markers stand as the model's gravity wants them."""
    port = free_port(socket.SOCK_DGRAM)
    vicon = {"address": "127.0.0.1", "port": port, "gravity_tolerance": math.pi, "silence": 0.3, **section}
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    config = check_config({"rig": {"name": "rig"}, "bus": {"endpoint": endpoint}, "vicon": vicon}, "test")
    with listening(config) as listener, Tracker(port) as tracker:
        yield listener, tracker


@contextmanager
def listening(config: RigConfig, folder: Path = Path()) -> Iterator[Listener]:
    """Run the driver of a configuration in a thread, beside a real hub."""
    ended = threading.Event()
    with Hub(config) as hub:
        listener = Listener(config, hub._session)
        one = MocapDriver(config, listener.section, Host(ended.is_set, listener.said.append), folder)
        thread = threading.Thread(target=one.run)
        thread.start()
        try:
            yield listener
        finally:
            ended.set()
            thread.join(PATIENCE_SECONDS)
            assert not thread.is_alive()
