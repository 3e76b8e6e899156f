"""Moving the target by hand with real processes: keys on a pseudo-terminal, a gamepad's events from a pipe."""

import os
import pty
import select
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zenoh

from tendond.offline.logs.log import load
from tendond.offline.replay.rerun import rerun
from tendond.schemas.messages import Mode, Status
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig

pytestmark = pytest.mark.sil

QUICK = '[reference]\nkind = "minimum_jerk"\nacross = 0.2\nbranch = "below_135"\nduration = 0.5\n'
RIGHT, LEFT = b"\x1b[C", b"\x1b[D"
EV_KEY, EV_ABS, ABS_X, BTN_START, BTN_TL = 1, 3, 0, 0x13B, 0x136


@pytest.fixture(scope="module")
def tracking(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Rig, zenoh.Session]]:
    with rig(tmp_path_factory.mktemp("teleop"), QUICK) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            one.arm(session)
            one.until(session, lambda status: abs(across(status) - 0.2) < 2e-3)
            yield one, session
            one.end(one.started["simulate"])
            one.end(one.started["run"])
            # What was moved by hand is in the log, and replayed to the last bit.
            log = one.folder / "run.mcap"
            assert sum(record.inputs.jog is not None for record in load(log).records) > 10
            outcome = rerun(log, jobs=1)
            assert outcome.compared > 100
            assert outcome.differing == 0, outcome.first


def across(status: Status) -> float:
    return 0.0 if status.tip is None else status.tip[0]


def settled(one: Rig, session: zenoh.Session) -> float:
    """Wait until the tip rests, and return its place across [m]."""
    places = [across(one.status(session))]
    deadline = time.monotonic() + PATIENCE_SECONDS
    while len(places) < 6 or max(places[-5:]) - min(places[-5:]) > 1e-4:
        assert time.monotonic() < deadline, places[-5:]
        time.sleep(0.1)
        places.append(across(one.status(session)))
    return places[-1]


class Terminal:
    """`tendond teleop` on a pseudo-terminal."""

    def __init__(self, one: Rig, *arguments: str) -> None:
        self._ours, theirs = pty.openpty()
        command = [sys.executable, "-m", "tendond.cli", "teleop", *arguments, "--config", str(one.config)]
        self.process = subprocess.Popen(command, cwd=one.folder, stdin=theirs, stdout=theirs, stderr=theirs)
        one.processes.append(self.process)  # type: ignore[arg-type]  # of bytes, and ended like the others
        os.close(theirs)
        self.said = b""

    def read(self, seconds: float) -> None:
        if select.select([self._ours], [], [], seconds)[0]:
            try:
                self.said += os.read(self._ours, 4096)
            except OSError:  # the other end is closed
                time.sleep(seconds)

    def until(self, words: bytes) -> None:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while words not in self.said:
            assert time.monotonic() < deadline, self.said
            self.read(0.05)

    def press(self, key: bytes, seconds: float = 0.0) -> None:
        """Press a key, and hold it for a time: a terminal repeats it."""
        deadline = time.monotonic() + seconds
        os.write(self._ours, key)
        while time.monotonic() < deadline:
            self.read(0.03)
            os.write(self._ours, key)

    def hang_up(self) -> None:
        os.close(self._ours)

    def ended(self) -> int:
        deadline = time.monotonic() + PATIENCE_SECONDS
        while self.process.poll() is None:
            assert time.monotonic() < deadline, self.said
            self.read(0.05)
        self.read(0.2)
        return self.process.returncode


def test_a_held_key_moves_the_tip_and_a_released_one_and_a_killed_program_hold_it(
    tracking: tuple[Rig, zenoh.Session],
) -> None:
    one, session = tracking
    begin = settled(one, session)
    terminal = Terminal(one, "--record", "path.csv")
    terminal.until(b"Esc stops")
    terminal.press(b"+")
    terminal.press(RIGHT, 1.0)
    there = settled(one, session)  # the key is no longer held
    assert there > begin + 0.01
    assert b"moving at +0.050 m/s" in terminal.said
    terminal.press(LEFT, 0.6)
    back = settled(one, session)
    assert back < there - 0.005
    terminal.press(b"q")
    assert terminal.ended() == 0
    assert b"the target holds its place" in terminal.said
    assert (one.folder / "path.csv").read_text().startswith("time [s],x [m],z [m]")
    assert one.status(session).mode is Mode.TRACKING
    assert abs(settled(one, session) - back) < 1e-3

    killed = Terminal(one)
    killed.until(b"Esc stops")
    killed.press(RIGHT, 0.6)
    killed.process.send_signal(signal.SIGKILL)
    killed.ended()
    held = settled(one, session)
    time.sleep(0.3)
    assert abs(settled(one, session) - held) < 1e-4
    assert one.status(session).mode is Mode.TRACKING


def test_a_gamepad_moves_the_tip_only_while_its_button_is_held_and_is_missed_when_it_is_gone(
    tracking: tuple[Rig, zenoh.Session], tmp_path: Path
) -> None:
    one, session = tracking

    def event(kind: int, code: int, value: int) -> bytes:
        return struct.pack("llHHi", 0, 0, kind, code, value)

    begin = settled(one, session)
    device = tmp_path / "event0"
    os.mkfifo(device)
    process = one.start("teleop", "--gamepad", str(device))
    with device.open("wb", buffering=0) as pad:
        pad.write(event(EV_ABS, ABS_X, -32768))
        time.sleep(0.5)
        assert abs(settled(one, session) - begin) < 1e-3  # the button is not held
        pad.write(event(EV_KEY, BTN_TL, 1)[:10])
        pad.write(event(EV_KEY, BTN_TL, 1)[10:])  # a read may end within an event
        one.until(session, lambda status: across(status) < begin - 0.02)
        pad.write(event(EV_KEY, BTN_TL, 0))
        there = settled(one, session)
        pad.write(event(EV_ABS, ABS_X, 32767) + event(EV_KEY, BTN_TL, 1))
        one.until(session, lambda status: across(status) > there + 0.005)
    _, said = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 1
    assert "the input is lost" in said
    assert one.status(session).mode is Mode.TRACKING
    settled(one, session)


def test_escape_stops_and_releases_the_tendons_and_then_there_is_nothing_to_move(
    tracking: tuple[Rig, zenoh.Session],
) -> None:
    one, session = tracking
    terminal = Terminal(one)
    terminal.until(b"Esc stops")
    terminal.press(b"\x1b")
    assert terminal.ended() == 0
    assert b"stopped: releasing the tendons" in terminal.said
    one.until(session, lambda status: status.mode is Mode.IDLE)
    again = Terminal(one)
    assert again.ended() == 2
    assert b"the rig is idle" in again.said
    assert b"tendond arm --wait" in again.said
