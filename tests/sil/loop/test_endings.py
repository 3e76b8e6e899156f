"""Ends of a controller while it tracks, by a signal or killed: tendons, exit status, log and its replay."""

import signal
from dataclasses import dataclass
from pathlib import Path

import pytest

from tendond.offline.logs.log import load
from tendond.offline.replay.rerun import rerun
from tendond.schemas.messages import Mode, Status
from tests.sil.rig import rig

pytestmark = pytest.mark.sil

TRACKED = 150
"""Cycles of tracking before the end."""


@dataclass(frozen=True)
class Ending:
    """End of a run.

    Attributes:
        code: exit status. said: standard error. log: path of the log.
        start: first status with a tip, before arming.
    """

    code: int
    said: str
    log: Path
    start: Status


@pytest.fixture(scope="module")
def endings(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Ending]:
    """Run and end three controllers, one after another, of one simulator; the first is killed."""
    found: dict[int, Ending] = {}
    with rig(tmp_path_factory.mktemp("endings")) as one:
        simulator = one.start("simulate")
        for number in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT):
            log = one.folder / f"{number.name}.mcap"
            controller = one.start("run", "--log", str(log))
            with one.session() as session:
                start = one.until(session, lambda s: s.tip is not None)
                one.arm(session)
                one.pass_ticks(session, TRACKED)
                code, said = one.end(controller, number)
            found[number] = Ending(code, said, log, start)
        assert one.end(simulator)[0] == 0
    return found


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_while_tracking_releases_the_tendons_and_exits_with_0_or_130(
    endings: dict[int, Ending], number: int
) -> None:
    ending = endings[number]
    assert ending.code == (130 if number == signal.SIGINT else 0)
    assert "stopped" in ending.said
    assert "Traceback" not in ending.said
    last = load(ending.log).records[-1]
    assert (last.mode, last.tension_estimate, last.command.armed) == (Mode.IDLE, (0.0,) * 4, False)


def test_a_killed_controller_makes_the_simulated_servos_release(endings: dict[int, Ending]) -> None:
    killed = load(endings[signal.SIGKILL].log).records[-1]
    assert killed.mode is Mode.TRACKING
    assert killed.measured is not None
    assert killed.measured[0] > 0.1
    after = endings[signal.SIGTERM].start
    assert after.mode is Mode.IDLE
    assert after.tip is not None
    assert after.tip[2] > 0.4


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_live_run_replays_to_the_last_bit(endings: dict[int, Ending], number: int) -> None:
    log = endings[number].log
    outcome = rerun(log)
    assert (outcome.first, outcome.gaps.missing, outcome.complete) == (None, [], number != signal.SIGKILL)
    assert outcome.compared > 100
    assert rerun(log, first=outcome.compared // 2).first is None
