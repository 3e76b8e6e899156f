"""The page in a real browser, beside a real controller and simulator: what it shows, and what it asks for."""

import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
import zenoh

from tendond.daemon.recording.channels import CYCLE
from tendond.offline.logs.log import load
from tendond.offline.logs.run import open_run
from tendond.offline.replay.rerun import rerun
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction
from tests.sil.dashboard.chromium import Tab, chromium
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig
from tests.unit.offline.browser import browser

pytestmark = [pytest.mark.sil, browser]

QUICK = """
[reference]
kind = "minimum_jerk"
across = 0.2
branch = "below_135"
duration = 0.5
[log]
idle_period = 0.0
[faults]
pose_age = 1.0
pose_timeout = 1.0
tendon_timeout = 1.2
overrun_time = 0.9
"""
"""A short motion, a log of every cycle, and patience: a browser draws beside it."""

STOP_SECONDS = 0.1
"""From the key to the request in the record; a cycle is 0.01 s, so that a starved machine is not what is measured."""

LIVE = "document.body.dataset.live === 'yes'"
READ = """(() => { const { seq, mode } = document.body.dataset; return {
  seq: Number(seq), mode, tick: page.frame.tick, now: page.frame.now,
  tension: [0, 1, 2, 3].map((k) => document.getElementById(`tension-${k}`).textContent),
  pulled: [...document.querySelectorAll("#tendon-rows td:nth-child(4)")].map((one) => one.textContent),
  rows: Object.fromEntries(
    [...document.querySelectorAll("#rows tr")].map((one) => [...one.cells].map((cell) => cell.textContent))),
  entities: page.frame.scene.entities.map((one) => one.id),
  tip: page.frame.scene.entities[0].spheres[0].pose.position, ghost: page.frame.ghost, target: page.frame.target,
}; })()"""
"""What the page shows in one moment."""

PRESSED = "window.pressed = []; addEventListener('keydown', () => pressed.push(Date.now()), true);"
"""Notes the time of each key [ms], before the page takes it."""


@dataclass
class Shown:
    """A rig with the page open in a browser; what the page has shown, to be compared with the log."""

    rig: Rig
    session: zenoh.Session
    tab: Tab
    url: str
    dashboard: "subprocess.Popen[str]"
    read: list[dict[str, Any]] = field(default_factory=list)
    pressed: list[float] = field(default_factory=list)
    """Times of the space bar [s]."""

    def mode(self, mode: str) -> None:
        self.tab.until(f"{LIVE} && document.body.dataset.mode === '{mode}'")

    def arm(self) -> None:
        """Arm by the page, once the tip rests."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while self.rig.status(self.session).mode is Mode.IDLE:
            assert time.monotonic() < deadline, self.tab.text("said")
            self.tab.until("!document.getElementById('arm').disabled")
            self.tab.click("arm")
            self.tab.click("arm-now")
            self.tab.until("page.waiting.size === 0")
        self.mode("tracking")

    def press_space(self) -> None:
        self.tab.press("Space", " ")
        self.pressed.append(1e-3 * self.tab.get("pressed.at(-1)"))


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    with rig(tmp_path_factory.mktemp("dashboard"), QUICK) as one:
        one.controller()
        one.start("simulate")
        dashboard = one.start("dashboard", "--port", "0")
        assert dashboard.stderr is not None
        url = next(line for line in dashboard.stderr if "http://" in line).split()[-1]
        with one.session() as session, chromium(one.folder) as tab:
            tab.call("Page.enable")
            tab.call("Page.addScriptToEvaluateOnNewDocument", source=PRESSED)
            tab.open(url)
            tab.until(LIVE)
            yield Shown(one, session, tab, url, dashboard)


def test_arming_asks_first_and_the_page_shows_the_rig(shown: Shown) -> None:
    tab = shown.tab
    tab.until("!document.getElementById('arm').disabled")
    tab.click("arm")
    assert tab.get("getComputedStyle(document.getElementById('confirm')).display") == "block"
    tab.click("arm-not")
    assert tab.get("document.getElementById('confirm').hidden")
    shown.rig.pass_ticks(shown.session, 20)
    assert shown.rig.status(shown.session).mode is Mode.IDLE
    shown.arm()
    shown.rig.until(shown.session, lambda s: s.tip is not None and abs(s.tip[0] - 0.2) < 2e-3)
    for _ in range(10):
        shown.read.append(tab.get(READ))
        time.sleep(0.1)
    last = shown.read[-1]
    assert last["mode"] == "tracking"
    assert last["entities"] == ["rod", "trail"]
    assert last["rows"]["pose"].endswith("ms old")
    assert last["target"][0] == pytest.approx(0.2)
    assert last["ghost"][-1] == pytest.approx(last["target"], abs=0.02)
    assert [last["tip"][axis] for axis in "xyz"] == pytest.approx(last["target"], abs=0.03)
    assert tab.get("document.getElementById('scene').width") > 100
    painted = "[...document.getElementById('scene').getContext('2d').getImageData(0, 0, 2000, 900).data].some((v) => v)"
    assert tab.get(painted)


def test_a_gain_is_set_and_shown(shown: Shown) -> None:
    tab = shown.tab
    tab.until("document.querySelector('[aria-label=\"limits.tension_max\"]') !== null")
    tab.get("document.querySelector('[aria-label=\"limits.tension_max\"]').value = '50'")
    tab.get(
        "document.querySelector('[aria-label=\"limits.tension_max\"]').closest('tr').querySelector('button').click()"
    )
    shown.rig.until(
        shown.session, lambda s: "limits.tension_max" in s.tuned and s.tuned["limits.tension_max"].value == 50
    )
    tab.until("document.getElementById('tension-max').textContent === '50'")


def test_a_held_button_moves_the_target_and_a_released_one_does_not(shown: Shown) -> None:
    before = shown.rig.status(shown.session).target[0]
    shown.tab.mouse("mousePressed", "on")
    shown.rig.until(shown.session, lambda s: s.tip is not None and s.tip[0] > before + 0.02)
    shown.tab.mouse("mouseReleased", "on")
    shown.rig.pass_ticks(shown.session, 60)
    held = shown.rig.status(shown.session).target
    shown.rig.pass_ticks(shown.session, 60)
    assert shown.rig.status(shown.session).target == held
    assert held[0] > before + 0.01


def test_a_page_elsewhere_cannot_stop_it(shown: Shown) -> None:
    """A page of another origin in the same browser: neither its WebSocket opens nor is its stop carried out."""
    port = shown.url.rsplit(":", 1)[1].strip("/")
    shown.tab.open("data:text/html,<title>elsewhere</title>")
    opened = f"""new Promise((done) => {{
      const socket = new WebSocket("ws://localhost:{port}/live");
      socket.onopen = () => done("open");
      socket.onerror = () => done("refused");
    }})"""
    assert shown.tab.get(opened) == "refused"
    stop = f"fetch('http://localhost:{port}/stop', {{ method: 'POST', mode: 'no-cors' }}).then(() => 1, () => 0)"
    shown.tab.get(stop)
    shown.rig.pass_ticks(shown.session, 20)
    assert shown.rig.status(shown.session).mode is Mode.TRACKING
    shown.tab.open(shown.url)
    shown.mode("tracking")


def test_the_space_bar_stops_also_from_a_field_and_while_a_reference_is_planned(shown: Shown) -> None:
    tab = shown.tab
    tab.click("more")
    shown.press_space()
    shown.rig.until(shown.session, lambda s: s.mode in (Mode.RELEASING, Mode.IDLE))
    assert tab.get("document.activeElement.id") == "more"
    shown.mode("idle")
    tab.until("page.stopping === null")
    assert "stop" in tab.text("said")
    for _ in range(4):
        shown.press_space()
        tab.until("page.stopping === null")
    tab.get("document.getElementById('target-value').value = '0.15'")
    tab.click("set-reference")
    shown.press_space()
    tab.until("page.stopping === null")
    tab.until("page.waiting.size === 0")
    shown.rig.until(shown.session, lambda s: abs(s.target[0] - 0.15) < 1e-6)


@pytest.mark.parametrize(("width", "height"), [(360, 640), (390, 844), (768, 1024)])
def test_a_phone_scrolls_in_one_direction_only_and_always_shows_the_stop(shown: Shown, width: int, height: int) -> None:
    tab = shown.tab
    tab.resize(width, height, mobile=True)
    tab.get("document.querySelector('details').open = true")
    assert tab.get("document.documentElement.scrollWidth <= innerWidth && innerWidth") == width
    for place in ("0", "document.body.scrollHeight"):
        tab.get(f"scrollTo(0, {place})")
        top = "((r) => document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2).id)"
        assert tab.get(f"{top}(document.getElementById('stop').getBoundingClientRect())") == "stop"
    shown.tab.call("Emulation.clearDeviceMetricsOverride")


def test_a_lost_dashboard_and_a_lost_controller_are_said_and_nothing_is_shown_as_live(shown: Shown) -> None:
    tab, controller = shown.tab, shown.rig.started["run"]
    shown.dashboard.send_signal(signal.SIGSTOP)
    tab.until("document.getElementById('alarm-what').textContent === 'CONNECTION LOST'")
    assert not tab.get(LIVE)
    assert tab.text("mode") == "connection lost"
    assert tab.get("parseFloat(getComputedStyle(document.getElementById('alarm-what')).fontSize)") > 20
    assert tab.get("[...document.querySelectorAll('#arm, #reset, #on, #set-law')].every((one) => one.disabled)")
    shown.dashboard.send_signal(signal.SIGCONT)
    tab.until(LIVE)
    controller.send_signal(signal.SIGSTOP)
    tab.until("document.getElementById('alarm-what').textContent === 'NO CONTROLLER'")
    assert not tab.get(LIVE)
    tab.press("Space", " ")
    tab.until("document.getElementById('said').textContent.startsWith('STOP NOT CONFIRMED')")
    controller.send_signal(signal.SIGCONT)
    tab.until(LIVE)
    tab.until("page.stopping === null")
    assert "NOT CONFIRMED" not in tab.text("said")


def test_what_was_shown_and_asked_for_is_in_the_log(shown: Shown) -> None:
    """Last: it ends the processes."""
    assert shown.rig.end(shown.dashboard)[0] == 0
    shown.tab.until("document.getElementById('alarm-what').textContent === 'CONNECTION LOST'")
    shown.rig.end(shown.rig.started["simulate"])
    shown.rig.end(shown.rig.started["run"])
    records = load(shown.rig.folder / "run.mcap").records
    by_seq = {one.command.seq: one for one in records}
    by_tick = {one.tick: one for one in records}
    assert len({one["seq"] for one in shown.read}) > 5
    for one in shown.read:
        command = by_seq[one["seq"]].command
        assert [float(text) for text in one["tension"]] == pytest.approx(command.tension, abs=0.0051)
        assert [float(text) for text in one["pulled"]] == pytest.approx(
            [1e3 * d for d in command.displacement], abs=0.051
        )
        assert by_tick[one["tick"]].mode.value == one["mode"]
    assert any(one.inputs.settings == {"limits.tension_max": 50.0} for one in records)
    assert any((one.inputs.jog or 0.0) > 0.0 for one in records)
    stops = stop_times(shown.rig.folder / "run.mcap")
    delays = [min(stop for stop in stops if stop > at) - at for at in shown.pressed]
    assert len(delays) == 6
    assert min(delays) < STOP_SECONDS, delays
    outcome = rerun(shown.rig.folder / "run.mcap", jobs=1, last=records[0].tick + 300)
    assert outcome.differing == 0, outcome.first


def stop_times(log: Path) -> list[float]:
    """Return the times of the cycles that took a stop, on the clock of `Date.now()` [s]."""
    run = open_run(log)
    return [
        1e-9 * message.log_time
        for topic, message in run.messages((CYCLE.topic,))
        if run.decode(topic, CycleRecord, message.data).inputs.request is ControlAction.STOP
    ]
