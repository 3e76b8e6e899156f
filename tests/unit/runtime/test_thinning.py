"""An idle controller's log: thin, and still replayed to the last bit; everything that surrounds an event is in it."""

import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.recording import foxglove
from tendond.daemon.recording.channels import LOG
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.recording.thinning import HELD_SECONDS, IDLE_SECONDS
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.offline.logs.info import info
from tendond.offline.logs.log import load
from tendond.offline.logs.recover import recover
from tendond.offline.logs.run import open_run
from tendond.offline.replay.rerun import rerun
from tendond.offline.replay.variant import same_inputs
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

CONFIG = """
[rod]
nodes = 6
[simulator.rod]
nodes = 6
[simulator.mocap]
noise = 1e-4
[log]
idle_period = 5.0
"""
CYCLES, ARM_AT, STOP_AT = 4000, 3333, 3400
PATIENCE = 60.0  # [s] for the recorder on a busy machine
Requests = Callable[[int], ControlAction | None]


def operator(tick: int) -> ControlAction | None:
    return {ARM_AT: ControlAction.ARM, STOP_AT: ControlAction.STOP}.get(tick)


def run(path: Path, config: RigConfig, cycles: int = CYCLES, requests: Requests = operator, late: bool = False) -> None:
    """Controller and plant in lockstep: idle, armed for a while, idle; `late`: the recorder begins when all is over."""
    over = threading.Event()

    def line() -> foxglove.Log:
        assert not late or over.wait(PATIENCE)
        return foxglove.log_line(0, foxglove.LogLevel.INFO, "begun")

    setup = CycleSetup.from_config(config)
    plant = Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))
    state = initial_state(setup)
    now_ns = [0]
    with RunLog(path, config, setup.rod, now=lambda: now_ns[0], queue=1_000_000) as run_log:
        run_log._recorder.put(LOG, 0, line)
        run_log.state(state)
        for tick in range(cycles):
            now_ns[0] = round(tick * config.loop.period * 1e9)
            pose, tendon_state, _ = plant.observe(now_ns[0])
            inputs = CycleInputs(pose=pose, tendon_state=tendon_state, request=requests(tick))
            state, command, record = step(setup, state, inputs)
            run_log.cycle(record, None, state.rod, None)
            run_log.state(state)
            plant.step(command)
        over.set()
        deadline = time.monotonic() + PATIENCE
        while run_log.waiting and time.monotonic() < deadline:
            time.sleep(0.01)
    assert (run_log.error, run_log.dropped) == ("", 0)
    put, written, dropped = run_log._counts
    assert (put, dropped) == (written, 0)


@pytest.fixture(scope="module")
def thin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("thin") / "run.mcap"
    run(path, parse_config(CONFIG, "thin"))
    return path


def test_a_thin_log_replays_to_the_last_bit_and_names_what_was_left_out(thin: Path) -> None:
    outcome = rerun(thin, jobs=1)
    logged = len(load(thin).records)
    assert (outcome.first, outcome.compared) == (None, logged)
    assert (outcome.gaps.missing, outcome.gaps.passed_over) == ([], 0)
    assert outcome.gaps.left_out == CYCLES - logged > 500
    assert rerun(thin, jobs=2).compared == logged


def test_a_log_is_the_same_however_late_the_recorder_is(thin: Path, tmp_path: Path) -> None:
    path = tmp_path / "late.mcap"
    run(path, parse_config(CONFIG, "thin"), late=True)
    late, prompt = open_run(path), open_run(thin)
    for topic in ("cycle", "state"):
        assert [one.data for _, one in late.messages((topic,))] == [one.data for _, one in prompt.messages((topic,))]


def test_what_led_to_an_event_and_ten_seconds_after_it_are_in_the_log(thin: Path) -> None:
    ticks = [record.tick for record in load(thin).records]
    period = RigConfig().loop.period
    assert ticks == sorted(set(ticks))
    first = ARM_AT - round(HELD_SECONDS / period)
    assert set(range(first, CYCLES)) <= set(ticks)
    assert set(range(round(IDLE_SECONDS / period))) <= set(ticks)
    idle = [tick for tick in ticks if round(1.2 * IDLE_SECONDS / period) < tick < first]
    assert len(idle) == 40  # of these 19.3 s: a tenth of a second every five
    modes = {record.mode for record in load(thin).records}
    assert {Mode.IDLE, Mode.RELEASING} < modes  # and what arming begins with


def test_tools_tell_what_was_left_out_from_what_is_missing(thin: Path, tmp_path: Path) -> None:
    found = info(thin)
    assert found["missing_ticks"] == 0
    assert found["left_out"] == CYCLES - found["cycles"]
    assert recover(thin, tmp_path / "out.mcap").missing == []


def test_another_law_runs_on_the_inputs_of_a_thin_log(thin: Path, tmp_path: Path) -> None:
    config = parse_config(CONFIG + "[control]\nlaw = 'sliding_mode'", "thin")
    found = same_inputs(thin, config, tmp_path / "new.mcap", "law")
    assert found.cycles == len(load(thin).records)
    assert rerun(tmp_path / "new.mcap", jobs=1).first is None


def growth(folder: Path, idle_period: float, first: int, last: int) -> float:
    """Growth of an idle log between two lengths [bytes per cycle]: what files begin and end with is not in it."""
    sizes = []
    for cycles in (first, last):
        path = folder / f"{idle_period}-{cycles}.mcap"
        run(path, parse_config(CONFIG.replace("5.0", str(idle_period)), "thin"), cycles, lambda tick: None)
        sizes.append(path.stat().st_size)
    return (sizes[1] - sizes[0]) / (last - first)


def test_an_idle_log_grows_by_a_hundredth_of_a_full_one(tmp_path: Path) -> None:
    """Take the default period: a minute, in which there is one sample."""
    thin_rate = growth(tmp_path, RigConfig().log.idle_period, 1500, 7500)
    assert 0.0 < thin_rate < growth(tmp_path, 0.0, 500, 1500) / 100


def test_with_a_period_of_zero_every_cycle_is_logged(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    run(path, parse_config(CONFIG.replace("5.0", "0.0"), "full"), 2000, lambda tick: None)
    assert [record.tick for record in load(path).records] == list(range(2000))
