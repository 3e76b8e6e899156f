"""`tendond watch` in a terminal, beside a rig that comes, tracks, goes and comes back."""

import codecs
import fcntl
import os
import pty
import re
import select
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random

import pytest
import zenoh

from tendond.cli.rig.watch import Listener
from tendond.schemas.config.rig import check_config
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose
from tendond.schemas.wire import encode
from tests.rig.tracker import free_port
from tests.sil.background import running
from tests.sil.bus.live import Live
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig

pytestmark = pytest.mark.sil

WATCH = [sys.executable, "-m", "tendond.cli", "watch", "--config"]
CONTROL = re.compile(r"\x1b\[[0-9;?]*[A-Za-z]")
HOME = "\x1b[H"


class Terminal:
    """Pseudo-terminal with a program on it, and the last whole frame that it has drawn."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        self._master, slave = pty.openpty()
        self.resize(80, 24)
        inherited = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
        self.process = subprocess.Popen(
            command,
            stdin=slave,
            stdout=slave,
            stderr=slave,
            env={**inherited, "TERM": "xterm-256color", **environment},
        )
        os.close(slave)
        self.all = ""
        self._decoder = codecs.getincrementaldecoder("utf-8")()

    def resize(self, width: int, height: int) -> None:
        """Resize the terminal as a person does who drags its corner."""
        fcntl.ioctl(self._master, termios.TIOCSWINSZ, struct.pack("HHHH", height, width, 0, 0))

    def read(self, seconds: float) -> None:
        """Whatever the program writes meanwhile."""
        deadline = time.monotonic() + seconds
        while (left := deadline - time.monotonic()) > 0.0:
            if select.select([self._master], [], [], left)[0]:
                try:
                    self.all += self._decoder.decode(os.read(self._master, 65536))
                except OSError:  # it has ended
                    return

    @property
    def frame(self) -> str:
        """Return the last whole frame, without colours."""
        frames = self.all.split(HOME)
        return CONTROL.sub("", frames[-2]) if len(frames) > 2 else ""

    def until(self, *wanted: str, wider_than: int = 0) -> str:
        """Wait for a frame that has all of it, and a row with more than so many columns."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not all(part in self.frame for part in wanted) or not any(
            len(row) > wider_than for row in self.frame.splitlines()
        ):
            assert time.monotonic() < deadline, f"no {wanted}, {wider_than} wide, in:\n{self.frame}"
            assert self.process.poll() is None, self.all
            self.read(0.1)
        return self.frame

    def close(self) -> None:
        """End what is left of it."""
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        os.close(self._master)


@contextmanager
def watching(one: Rig, **environment: str) -> Iterator[Terminal]:
    """The live view of a rig in a terminal."""
    terminal = Terminal([*WATCH, str(one.config)], environment)
    try:
        yield terminal
    finally:
        terminal.close()


def test_watch_follows_a_rig_through_its_life(tmp_path: Path) -> None:
    with rig(tmp_path) as one, watching(one) as terminal:
        terminal.until("waiting for the controller of rig 'sil'")

        controller = one.controller()
        one.start("simulate")
        frame = terminal.until("IDLE", "disarmed", "x-z", "y-z", "▲", "●")
        assert len(frame.splitlines()) <= 24
        assert max(len(row) for row in frame.splitlines()) <= 80, frame

        with one.session() as session:
            one.arm(session)
        terminal.until("TRACKING", "armed by the operator", "340.0", "█")

        terminal.resize(130, 40)
        frame = terminal.until("TRACKING", wider_than=100)
        assert 24 < len(frame.splitlines()) <= 40

        one.end(controller, signal.SIGKILL)
        terminal.until("waiting for the controller")
        one.start("run", "--log", str(tmp_path / "again.mcap"))
        terminal.until("IDLE", "disarmed")

        terminal.process.send_signal(signal.SIGINT)
        terminal.read(1.0)
        assert terminal.process.wait(10.0) == 130
        assert "\x1b[?1049l" in terminal.all, "the screen is not given back"
        assert "\x1b[3" in terminal.all, "no colours"
        assert "Traceback" not in terminal.all


def test_watch_has_no_colours_where_they_are_not_wanted(tmp_path: Path) -> None:
    with rig(tmp_path) as one, watching(one, NO_COLOR="1") as terminal:
        terminal.until("waiting for the controller")
        terminal.read(0.5)
        assert not re.search(r"\x1b\[[0-9;]*[34][0-7]m", terminal.all)


def test_watch_once_without_a_controller_is_refused(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        alone = one.command("watch", "--once")
    assert alone.returncode == 1
    assert alone.stderr.startswith("tendond: no controller of rig 'sil'")


def test_watch_once_and_watch_in_a_pipe(live: Live) -> None:
    one = live.rig
    one.arm(live.session)
    once = one.command("watch", "--once")
    assert (once.returncode, once.stderr) == (0, "")
    assert "TRACKING" in once.stdout
    assert "\x1b" not in once.stdout
    piped = subprocess.Popen([*WATCH, str(one.config)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert piped.stdout is not None
    lines: list[str] = []
    while not lines or "tracking (armed by the operator), tip" not in lines[-1]:
        lines.append(piped.stdout.readline())
        assert len(lines) < 10, lines
    piped.stdout.close()  # the reader has enough
    assert piped.wait(30.0) == 1
    assert piped.stderr is not None
    assert piped.stderr.read() == ""
    piped.stderr.close()


@pytest.mark.parametrize("rate", [100.0, 250.0])
def test_the_rate_that_is_shown_is_that_of_a_camera_with_jitter_and_a_burst(rate: float) -> None:
    """A real publisher, whose mean rate is measured by its own stamps; the frames are read as the live view does."""
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    own = zenoh.Config()
    own.insert_json5("listen/endpoints", f'["{endpoint}"]')
    own.insert_json5("scouting/multicast/enabled", "false")
    config = check_config({"rig": {"name": "eve"}, "bus": {"endpoint": endpoint}}, "test")
    ending, jitter, sent = threading.Event(), Random(3), list[int]()

    def publish() -> None:
        began, number = time.monotonic(), 0
        while not ending.is_set():
            held = 2.0 <= (time.monotonic() - began) % 4.0 < 2.15  # held up, then a burst
            while not held and time.monotonic() > began + (number + jitter.uniform(0.0, 0.3)) / rate:
                sent.append(time.monotonic_ns())
                pose = TipPose(seq=number, stamp_ns=sent[-1], position=(0.0, 0.0, 0.5), orientation=(1.0, 0.0, 0, 0))
                session.put(key("eve", TIP_POSE), encode(pose))
                number += 1
            time.sleep(0.2 / rate)

    with zenoh.open(own) as session, running(publish, ending):
        listener = Listener(config)
        shown: list[float] = []
        try:
            while len(shown) < 70:
                listener.listen()
                shown.append(listener.snapshot.pose_stream.rate(time.monotonic()))
                time.sleep(0.1)
        finally:
            listener.close()
    true = (len(sent) - 1) / (1e-9 * (sent[-1] - sent[0]))
    assert all(one == pytest.approx(true, rel=0.05) for one in shown[20:]), (true, shown)
    assert sorted(shown[20:])[25] == pytest.approx(true, rel=0.02)
