"""Inputs by hand: keys of a real pseudo-terminal, and a gamepad's events through a pipe."""

import os
import pty
import struct
import termios
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.cli.teleop.gamepad import DEAD_ZONE, Gamepad
from tendond.cli.teleop.keyboard import ESCAPE_SECONDS, KEY_SECONDS, Keyboard
from tests.unit.cli.commands import tendond

MOMENT = 0.01
SYN, KEY, ABSOLUTE = 0, 1, 3
DROPPED, X, LEFT_SHOULDER, EAST, START = 3, 0, 0x136, 0x131, 0x13B


class Keys:
    """A keyboard on a pseudo-terminal; `ours` is the end at which keys are typed."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ours, theirs = pty.openpty()
        self.theirs = open(theirs)  # noqa: SIM115  # the fixture closes it
        monkeypatch.setattr("sys.stdin", self.theirs)
        self.keyboard = Keyboard()

    def type(self, keys: bytes) -> None:
        os.write(self.ours, keys)


@pytest.fixture
def keys(monkeypatch: pytest.MonkeyPatch) -> Iterator[Keys]:
    one = Keys(monkeypatch)
    before = termios.tcgetattr(one.theirs)
    with one.keyboard:
        yield one
    assert termios.tcgetattr(one.theirs) == before, "the terminal is left as it was"
    one.theirs.close()


@pytest.mark.parametrize(("key", "sign"), [(b"\x1b[C", 1.0), (b"\x1bOD", -1.0), (b"l", 1.0), (b"a", -1.0)])
def test_a_key_counts_for_a_moment_and_no_longer(keys: Keys, key: bytes, sign: float) -> None:
    keys.type(key)
    wish = keys.keyboard.wait(MOMENT)
    assert (wish.part * sign > 0.0, wish.end) == (True, "")
    time.sleep(KEY_SECONDS)
    assert keys.keyboard.wait(MOMENT).part == 0.0


def test_another_key_lets_go_and_plus_and_minus_change_the_speed(keys: Keys) -> None:
    parts = []
    for typed in (b"l", b"x", b"+l", b"+++++l", b"--------l"):
        keys.type(typed)
        parts.append(keys.keyboard.wait(MOMENT).part)
    assert parts == [0.2, 0.0, 0.5, 1.0, 0.1]


def test_an_arrow_that_comes_in_two_parts_is_no_escape_and_an_escape_alone_stops(keys: Keys) -> None:
    keys.type(b"\x1b")
    assert keys.keyboard.wait(MOMENT).end == ""
    keys.type(b"[C")
    wish = keys.keyboard.wait(MOMENT)
    assert (wish.part > 0.0, wish.end) == (True, "")
    keys.type(b"\x1b")
    keys.keyboard.wait(MOMENT)
    time.sleep(ESCAPE_SECONDS)
    assert keys.keyboard.wait(MOMENT).end == "stop"


def test_q_ends_and_keys_after_it_move_nothing(keys: Keys) -> None:
    keys.type(b"lql")
    assert keys.keyboard.wait(MOMENT).end == "hold"


def event(kind: int, code: int, value: int) -> bytes:
    """A struct input_event, as linux/input.h has it."""
    return struct.pack("llHHi", 0, 0, kind, code, value)


def test_a_stick_moves_only_with_the_button_and_dropped_events_let_go(tmp_path: Path) -> None:
    device = tmp_path / "event0"
    os.mkfifo(device)
    with Gamepad(device) as gamepad, device.open("wb", buffering=0) as pad:

        def after(*events: bytes) -> float:
            pad.write(b"".join(events))
            return gamepad.wait(MOMENT).part

        held = event(KEY, LEFT_SHOULDER, 1)
        assert after(event(ABSOLUTE, X, 32767)) == 0.0
        assert after(held) == pytest.approx(1.0)
        assert after(event(SYN, DROPPED, 0)) == 0.0
        assert after(held) == pytest.approx(1.0)
        assert after(event(KEY, LEFT_SHOULDER, 0)) == 0.0
        assert after(held, event(ABSOLUTE, X, round(0.9 * DEAD_ZONE * 32767))) == 0.0
        assert after(event(ABSOLUTE, X, -32768)) == pytest.approx(-1.0)
        assert after(event(ABSOLUTE, X, -16384)) == pytest.approx(-(0.5 - DEAD_ZONE) / (1.0 - DEAD_ZONE), abs=1e-3)
        pad.write(event(KEY, START, 1))
        assert gamepad.wait(MOMENT) == (0.0, "hold")


@pytest.mark.parametrize(("code", "end"), [(EAST, "stop"), (START, "hold"), (None, "lost")])
def test_buttons_end_it_and_so_does_a_gamepad_that_is_gone(tmp_path: Path, code: int | None, end: str) -> None:
    device = tmp_path / "event0"
    os.mkfifo(device)
    with Gamepad(device) as gamepad:
        with device.open("wb", buffering=0) as pad:
            pad.write(event(ABSOLUTE, X, 32767) + event(KEY, LEFT_SHOULDER, 1))
            assert gamepad.wait(MOMENT).part > 0.0
            if code is not None:
                pad.write(event(KEY, code, 1))
                assert gamepad.wait(MOMENT) == (0.0, end)
        if code is None:
            assert gamepad.wait(MOMENT) == (0.0, "lost")


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["rig", "set", "--unchecked"], "give KEY=VALUE, or --configured"),
        (["rig", "set", "limits.tension_max"], "'limits.tension_max': give KEY=VALUE with a number"),
        (["rig", "set", "limits.tension_max=inf"], "give KEY=VALUE with a number"),
        (["rig", "set", "rod.length=0.4"], "rod.length is not tunable"),
        (["rig", "set", "tension_max=61"], "limits.tension_max = 61: must be 60 [N], the configuration's, or less"),
        (["teleop", "--gamepad", "/no/such/device"], "/no/such/device: the gamepad cannot be read (No such file"),
        (["teleop"], "keys need a terminal, which standard input is not"),
    ],
)
def test_what_cannot_be_is_a_line_before_anything_is_sent(
    arguments: list[str], reason: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with Path(os.devnull).open() as nothing:
        monkeypatch.setattr("sys.stdin", nothing)
        ended = tendond(capsys, *arguments)
    assert ended.status != 0
    assert reason in ended.said
    assert len(ended.said.splitlines()) == 1
