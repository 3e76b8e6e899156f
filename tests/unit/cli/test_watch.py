"""The live view: what it draws fits whatever the terminal is, and says what has been snapshot."""

import math
import re
from random import Random

import pytest
from rich.text import Text

from tendond.cli.watch.bus_snapshot import BusSnapshot
from tendond.cli.watch.canvas import Canvas
from tendond.cli.watch.health import BAD, folded, labelled
from tendond.cli.watch.plain import shown
from tendond.cli.watch.rod import sketch
from tendond.cli.watch.screen import frame, line
from tendond.cli.watch.text import bar, sparkline
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.health import LoopHealth
from tendond.schemas.messages import Mode, Status, TendonCommand, TendonState, TipPose

CONFIG = RigConfig()
SIXTEEN = parse_config(
    f"[rod]\ntendon_positions = {[[0.02, 0.001 * i] for i in range(16)]}\n"
    f"[simulator.rod]\ntendon_positions = {[[0.02, 0.001 * i] for i in range(16)]}\n",
    "sixteen",
)


def beside_the_rod(screen: str) -> str:
    """Join the rows of the screen's left column, as they were before they were folded."""
    return " ".join(" ".join(re.split("[│┌└]", row)[0] for row in screen.splitlines()).split())


def status(mode: Mode = Mode.TRACKING, reason: str = "armed by the operator", tendons: int = 4) -> Status:
    """Status of a controller that tracks."""
    health = LoopHealth(cycles=1234, missed_ticks=2, cycle_ms_median=0.51, cycle_ms_p99=0.99, log_dropped=0)
    return Status(
        seq=7, stamp_ns=0, rig="paper", mode=mode, reason=reason, tick=1234, law="backstepping", feedback="observer",
        tip=(0.34, 0.0, 0.05), target=(0.34, 0.0, 0.0475), tension=(1.0,) * tendons, displacement=(0.01,) * tendons,
        rejected={"teleport": 3, "malformed": 12}, loop=health,
    )  # fmt: skip


def watched(*, mode: Mode = Mode.TRACKING, reason: str = "armed by the operator", tendons: int = 4) -> BusSnapshot:
    """Two seconds of a rig: poses, commands and states at 100 Hz, a frame ten times a second."""
    snapshot = BusSnapshot()
    snapshot.add(status(mode, reason, tendons), 0.0)
    turned = (math.cos(0.8), 0.0, math.sin(0.8), 0.0)
    tension, displacement = (59.5, *[0.0] * (tendons - 1)), (0.0576, *[0.0] * (tendons - 1))
    for i in range(200):
        now = 0.01 * i
        snapshot.add(TipPose(seq=i, stamp_ns=0, position=(0.34, 0.0, 0.0575), orientation=turned), now)
        snapshot.add(
            TendonCommand(seq=i, stamp_ns=0, pose_seq=i, displacement=displacement, tension=tension, armed=True), now
        )
        snapshot.add(TendonState(seq=i, stamp_ns=0, displacement=displacement, tension=tension), now)
        if i % 10 == 0:
            snapshot.tick(now)
    return snapshot


def left_column(snapshot: BusSnapshot) -> str:
    """Words left of the plots, without the folds."""
    rows = frame(snapshot, CONFIG, 2.0, 80, 24).plain.splitlines()
    return " ".join(" ".join(row[:43] for row in rows).split())


@pytest.mark.parametrize("size", [(80, 24), (200, 60), (120, 16), (43, 12), (20, 5), (1, 1)])
@pytest.mark.parametrize("config", [CONFIG, SIXTEEN], ids=["four", "sixteen"])
@pytest.mark.parametrize("mode", [Mode.TRACKING, Mode.FAULT])
def test_a_frame_fits_every_terminal(size: tuple[int, int], config: RigConfig, mode: Mode) -> None:
    width, height = size
    snapshot = watched(mode=mode, reason="a very long reason, " * 20, tendons=len(config.rod.tendon_positions))
    for one in (snapshot, BusSnapshot()):
        rows = frame(one, config, 2.0, width, height).split("\n", allow_blank=True)
        assert len(rows) <= height
        assert all(row.cell_len <= width for row in rows)


def test_a_frame_of_eighty_by_twenty_four_says_everything() -> None:
    text = frame(watched(), CONFIG, 2.0, 80, 24).plain
    for part in ("TRACKING", "armed by the operator", "backstepping, observer", "340.0     0.0    57.5 mm", "10.0 mm",
                 "59.50", "57.6", "0.51 ms, p99 0.99 ms", "1234, 2 missed", "12 malformed, 3 teleport",
                 "0 entries dropped", "x-z", "y-z", "100.0 Hz", "●"):  # fmt: skip
        assert part in text, part


def test_a_fault_is_said_with_its_reason_whole() -> None:
    reason = "pose stale: no pose for 21 cycles; see the camera, then reset"
    text = frame(watched(mode=Mode.FAULT, reason=reason), CONFIG, 2.0, 80, 24).plain
    assert "FAULT" in text
    assert "pose stale: no pose for 21 cycles" in " ".join(row[:42].strip() for row in text.splitlines())


def test_without_commands_it_waits_for_the_controller() -> None:
    snapshot = watched()
    for text in (
        frame(snapshot, CONFIG, 4.0, 80, 24).plain,
        line(snapshot, CONFIG, 4.0),
        line(BusSnapshot(), CONFIG, 0.0),
    ):
        assert "waiting for the controller of rig 'paper' at tcp/127.0.0.1:7460" in text
    assert "last 2 s ago" in frame(snapshot, CONFIG, 4.0, 80, 24).plain


def test_a_viewer_who_may_not_hear_commands_sees_the_status() -> None:
    snapshot = BusSnapshot()
    assert snapshot.is_silent(0.0)
    snapshot.add(status(), 0.0)
    assert not snapshot.is_silent(2.0)
    assert "10.0" in frame(snapshot, CONFIG, 2.0, 80, 24).plain
    assert "tension 1.00 1.00 1.00 1.00 N" in line(snapshot, CONFIG, 2.0)
    assert snapshot.is_silent(3.0)


def test_the_line_has_the_numbers() -> None:
    assert line(watched(), CONFIG, 2.0) == (
        "tracking (armed by the operator), tip 340.0 0.0 57.5 mm, to target 10.0 mm, tension 59.50 0.00 0.00 0.00 N, "
        "displacement 57.6 0.0 0.0 0.0 mm, cycle 0.51 ms, 2 missed"
    )


def test_a_publisher_that_starts_anew_does_not_spoil_the_rate() -> None:
    snapshot = watched()
    for i in range(100):
        snapshot.add(
            TipPose(seq=i, stamp_ns=0, position=(0.0, 0.0, 0.5), orientation=(1.0, 0.0, 0.0, 0.0)), 2.0 + 0.02 * i
        )
    assert snapshot.pose_stream.rate(4.0) == pytest.approx(50.0, rel=0.02)
    assert snapshot.pose_stream.rate(9.0) == 0.0


def test_an_occluded_pose_leaves_no_trail() -> None:
    snapshot = watched()
    before = len(snapshot.trail)
    assert snapshot.pose is not None
    snapshot.add(snapshot.pose.model_copy(update={"valid": False}), 2.0)
    assert len(snapshot.trail) == before
    assert "hidden" in frame(snapshot, CONFIG, 2.0, 80, 24).plain


def test_the_canvas_puts_dots_where_they_belong() -> None:
    canvas = Canvas(2, 1, (0.0, 4.0, 0.0, 4.0))
    assert canvas.dot_size == 1.0
    canvas.dot((0.5, 3.5), "")
    canvas.dot((3.5, 0.5), "")
    canvas.dot((4.5, 0.5), "")
    assert [row.plain for row in canvas.lines()] == [chr(0x2801) + chr(0x2880)]


def test_a_line_has_no_holes_and_a_mark_stays_in_sight() -> None:
    canvas = Canvas(10, 5, (0.0, 1.0, 0.0, 1.0))
    canvas.line([(0.0, 0.01), (0.999, 0.01)], "")
    canvas.mark((5.0, -5.0), "x", "")
    rows = [row.plain for row in canvas.lines()]
    assert " " not in rows[-1]
    assert rows[-1][-1] == "x"


def test_the_sketch_of_the_rod_goes_from_base_to_tip_along_both_ends() -> None:
    quarter = (math.cos(math.pi / 4), 0.0, math.sin(math.pi / 4), 0.0)
    radius = 0.5 / (math.pi / 2)
    points = sketch((radius, 0.0, radius), quarter, 0.5, 0)
    assert points[0] == (0.0, 0.0)
    assert points[-1] == pytest.approx((radius, radius))
    for x, z in points:  # of a quarter of a circle, nearly
        assert math.hypot(x - radius, z) == pytest.approx(radius, rel=0.02)


def test_bars_and_sparks() -> None:
    assert bar(0.0, 4) == "    "
    assert bar(0.5, 4) == "██  "
    assert bar(0.53, 4) == "██▏ "
    assert bar(7.0, 4) == "████"
    assert sparkline([1e-5, 2e-4, 1e-2, 0.9], 10) == "▁▂▆█"
    assert sparkline([1.0] * 50, 8) == "█" * 8
    assert sparkline([1.0], 0) == ""


@pytest.mark.parametrize("encoding", ["latin-1", "ascii", "cp437", "no-such-encoding"])
def test_a_terminal_without_unicode_is_given_the_same_picture_in_ascii(encoding: str) -> None:
    drawn = frame(watched(), CONFIG, 2.0, 80, 24)
    text = shown(drawn, encoding)
    assert text.plain.isascii()
    assert [row.cell_len for row in text.split("\n")] == [row.cell_len for row in drawn.split("\n")]
    assert text.spans == drawn.spans
    assert "?" not in text.plain
    for part in ("TRACKING", "59.50", "+ x-z ", ":", "^", "o"):
        assert part in text.plain
    assert shown(drawn, "utf-8") is drawn


def test_the_room_that_is_left_for_logs_is_shown_in_days() -> None:
    snapshot = watched()
    assert snapshot.status is not None
    loop = snapshot.status.loop.model_copy(update={"log_days_left": 12.34})
    snapshot.add(snapshot.status.model_copy(update={"loop": loop, "seq": 8}), 2.0)
    assert "0 entries dropped, space for 12.3 days" in left_column(snapshot)


def test_the_tensions_at_the_tip_are_shown_where_the_model_has_friction() -> None:
    snapshot = watched()
    rubbing = status().model_copy(update={"tip_tension": (51.25, 0.0, 0.0, 0.0)})
    for one, there in ((status(), False), (rubbing, True)):
        snapshot.add(one, 1.99)
        assert ("51.25" in line(snapshot, CONFIG, 2.0)) == there
        text = frame(snapshot, CONFIG, 2.0, 80, 24).plain
        assert ("51.25" in text) == there
        assert max(map(len, text.splitlines())) <= 80


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0, 1000.0])
def test_the_rate_is_the_publishers_though_poses_are_taken_a_frame_at_a_time(rate: float) -> None:
    snapshot = BusSnapshot()
    jitter = Random(7)
    kept: list[TipPose] = []
    frames = 0
    for i in range(int(5.0 * rate)):
        stamp = i / rate + jitter.uniform(-0.2, 0.2) / rate
        if 2.0 < i / rate < 2.1:  # held up in the camera, then sent at once
            stamp = 2.1
        pose = TipPose(seq=i, stamp_ns=int(1e9 * (1.0 + stamp)), position=(0.0, 0.0, 0.5), orientation=(1.0, 0, 0, 0))
        kept = [*kept, pose][-32:]
        busy = 4.2 < i / rate < 4.7  # the viewer's own machine
        if i / rate >= 0.1 * frames + jitter.uniform(0.0, 0.05) and not busy:
            frames = round(10.0 * i / rate) + 1
            for one in kept:
                snapshot.add(one, i / rate)
            kept = []
            if i / rate > 1.0:
                assert snapshot.pose_stream.rate(i / rate) == pytest.approx(rate, rel=0.03)
    assert snapshot.pose_stream.rate(5.0) == pytest.approx(rate, rel=0.005)
    assert snapshot.pose_stream.rate(15.0) == 0.0


def test_a_value_wider_than_its_column_goes_on_below_beside_the_plots() -> None:
    snapshot = watched()
    assert snapshot.status is not None
    loop = snapshot.status.loop.model_copy(update={"phase_locked": True, "pose_wait_ms_median": 0.14})
    snapshot.add(snapshot.status.model_copy(update={"loop": loop, "seq": 8}), 2.0)
    rows = frame(snapshot, CONFIG, 2.0, 80, 24).plain.splitlines()
    assert max(map(len, rows)) == 80
    assert "…" not in "".join(rows)
    assert all(row[43:44] in "┌│└" for row in rows[1:]), "the plots have a straight edge"
    assert "locked to the poses, a pose waits 0.14 ms" in left_column(snapshot)


def test_a_folded_row_keeps_its_words_and_colours() -> None:
    row = labelled("refused", Text("the tip of the arm does not rest yet, wait until it does", style=BAD))
    parts = folded(row, 30)
    assert len(parts) > 1
    assert all(part.cell_len <= 30 for part in parts)
    assert " ".join(" ".join(part.plain for part in parts).split()) == " ".join(row.plain.split())
    assert all(any(span.style == BAD for span in part.spans) for part in parts)
    assert [part.plain for part in folded(labelled("x", Text("y" * 50)), 30)] == [labelled("x", Text("y" * 50)).plain]
