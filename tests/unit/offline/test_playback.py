"""The clock of a log that is played, with a clock of the test's own."""

import threading

import pytest

from tendond.offline.viewer.playback import Playback, Request

SECOND = 1_000_000_000
START, END = 100 * SECOND, 110 * SECOND


class Clock:
    """Time that passes when the test says so [s]."""

    def __init__(self) -> None:
        self.now = 5.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def playback(clock: Clock) -> Playback:
    playback = Playback(START, END, clock)
    assert playback.take_jump() == START
    return playback


def test_it_runs_from_the_start_and_no_further_than_the_end(clock: Clock, playback: Playback) -> None:
    clock.now += 2.0
    assert playback.state().now_ns == START + 2 * SECOND
    clock.now += 100.0
    assert playback.state().now_ns == END
    assert not playback.controlled


def test_a_held_log_stands_still_and_goes_on_from_there(clock: Clock, playback: Playback) -> None:
    clock.now += 2.0
    assert playback.ask(Request(play=False, speed=1.0)).now_ns == START + 2 * SECOND
    clock.now += 50.0
    assert playback.state().now_ns == START + 2 * SECOND
    playback.ask(Request(play=True, speed=1.0))
    clock.now += 1.0
    assert playback.state().now_ns == START + 3 * SECOND
    assert playback.controlled


def test_a_speed_counts_from_when_it_is_asked_for(clock: Clock, playback: Playback) -> None:
    clock.now += 2.0
    playback.ask(Request(play=True, speed=3.0))
    clock.now += 1.0
    assert playback.state().now_ns == START + 5 * SECOND


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_a_speed_that_is_none_leaves_the_present_one(speed: float, playback: Playback) -> None:
    playback.ask(Request(play=True, speed=2.0))
    assert playback.ask(Request(play=True, speed=speed)).speed == 2.0


@pytest.mark.parametrize(("asked", "reached"), [(104, 104), (0, 100), (500, 110)])
def test_a_jump_ends_a_wait_and_stays_within_the_log(asked: int, reached: int, playback: Playback) -> None:
    playback.ask(Request(play=False, speed=1.0))
    waits: list[bool] = []
    waiting = threading.Thread(target=lambda: waits.append(playback.wait_until(END)))
    waiting.start()
    playback.ask(Request(play=False, speed=1.0, seek_ns=asked * SECOND))
    waiting.join(timeout=30.0)
    assert waits == [False]
    assert playback.take_jump() == reached * SECOND
    assert playback.state().now_ns == reached * SECOND


def test_what_lies_before_a_held_moment_is_sent_at_once(clock: Clock, playback: Playback) -> None:
    clock.now += 2.0
    playback.ask(Request(play=False, speed=1.0))
    assert playback.wait_until(START + 2 * SECOND)


def test_the_end_lasts_until_it_is_played_again(clock: Clock, playback: Playback) -> None:
    clock.now += 20.0
    ended = playback.end()
    assert (ended.ended, ended.playing, ended.now_ns) == (True, False, END)
    assert playback.ask(Request(play=False, speed=1.0)).ended
    again = playback.ask(Request(play=True, speed=1.0))
    assert (again.ended, again.playing, again.now_ns) == (False, True, START)
    playback.wait_for_jump()
    assert playback.take_jump() == START


def test_a_jump_asked_for_at_the_last_moment_is_not_lost_at_the_end(clock: Clock, playback: Playback) -> None:
    playback.ask(Request(play=True, speed=1.0, seek_ns=START + SECOND))
    clock.now += 1.0
    assert not playback.end().ended
    playback.wait_for_jump()
    assert playback.take_jump() == START + SECOND


def test_without_a_request_it_begins_again(clock: Clock, playback: Playback) -> None:
    clock.now += 20.0
    assert playback.take_jump() == START
    assert playback.state().now_ns == START
