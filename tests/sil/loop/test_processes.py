"""The whole job with real processes: controller, simulator and operator on Zenoh."""

import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
import zenoh

from tendond.offline.logs.log import load
from tendond.schemas.config.presets import PAPER
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig

pytestmark = pytest.mark.sil

LANDING = np.array([0.3400, 0.0, 0.0398])


def cycles_as_bytes(log: Path) -> bytes:
    return b"\n".join(record.model_dump_json().encode() for record in load(log).records)


def test_lockstep_lands_where_the_papers_robot_lands_and_repeats_exactly(tmp_path: Path) -> None:
    """Two runs of 300 cycles, beside each other."""
    folders = [tmp_path / name for name in ("one", "two")]
    with ExitStack() as rigs:
        processes = []
        for folder in folders:
            folder.mkdir()
            one = rigs.enter_context(rig(folder, PAPER))
            processes.append(one.controller("--lockstep", "--cycles", "300", "--arm-at", "5"))
            processes.append(one.start("simulate", "--lockstep", "--cycles", "300"))
        assert [process.wait(120) for process in processes] == [0] * 4
    first, second = (cycles_as_bytes(folder / "run.mcap") for folder in folders)
    assert first == second
    last = load(tmp_path / "one" / "run.mcap").records[-1]
    assert last.measured is not None
    assert np.allclose(last.measured, LANDING, atol=0.5e-3)
    assert last.command.displacement[0] == pytest.approx(0.0586, abs=1e-4)


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Rig, zenoh.Session]]:
    """Yield the paper's rig with controller and simulator; the last of its tests ends them."""
    with rig(tmp_path_factory.mktemp("paper"), PAPER) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            yield one, session


def test_the_loop_finds_the_phase_of_a_cameras_poses_and_says_so(paper: tuple[Rig, zenoh.Session]) -> None:
    one, session = paper
    status = one.until(session, lambda s: s.loop.phase_locked and s.loop.pose_wait_ms_median is not None)
    assert status.loop.phase_in_words.startswith("locked to the poses, a pose waits ")


def test_real_time_arm_track_stop_and_end(paper: tuple[Rig, zenoh.Session]) -> None:
    one, session = paper
    one.arm(session)
    status = one.until(session, lambda s: np.allclose(s.tip or (0, 0, 0), LANDING, atol=0.5e-3))
    assert status.displacement[0] == pytest.approx(0.0586, abs=2e-4)
    assert one.ask(session, ControlAction.STOP).done
    one.until(session, lambda s: s.mode is Mode.IDLE)
    assert one.end(one.started["simulate"])[0] == 0
    assert one.end(one.started["run"])[0] == 0
    records = load(one.folder / "run.mcap").records
    assert {record.mode for record in records} == {Mode.IDLE, Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING}
    assert [record.tick for record in records] == list(range(len(records)))


def test_a_killed_simulator_makes_the_controller_release_and_fault_not_crash(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        controller, simulator = one.controller(), one.start("simulate")
        with one.session() as session:
            one.arm(session)
            simulator.kill()
            status = one.until(session, lambda s: s.mode is Mode.FAULT)
            assert "pose stale" in status.reason
            one.until(session, lambda s: s.tension == (0.0,) * 4)
            assert not one.ask(session, ControlAction.ARM).done
        assert one.end(controller)[0] == 0


def test_bad_payloads_are_dropped_and_counted(tmp_path: Path) -> None:
    payloads = {
        b"": "malformed",
        b"{": "malformed",
        b'{"version":1,"seq":1,"stamp_ns":0,"position":[NaN,0,0],"orientation":[1,0,0,0]}': "not finite",
        b'{"version":9,"seq":1,"stamp_ns":0,"position":[0,0,0],"orientation":[1,0,0,0]}': "wrong version",
        b'{"version":1,"seq":1,"stamp_ns":0,"position":[0,0,0],"orientation":[1,1,0,0]}': "bad quaternion",
        b"x" * 10_000_000: "too large",
    }
    with rig(tmp_path) as one:
        controller = one.controller()
        with one.session() as session:
            one.status(session)
            for payload in payloads:
                session.put(key(one.name, TIP_POSE), payload, congestion_control=zenoh.CongestionControl.BLOCK)
            session.delete(key(one.name, TIP_POSE))
            status = one.until(session, lambda s: sum(s.rejected.values()) == len(payloads) + 1)
        expected = {reason: list(payloads.values()).count(reason) for reason in payloads.values()}
        assert status.rejected == {**expected, "deleted": 1}
        assert status.tip is None
        assert one.end(controller)[0] == 0


def run(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-m", "tendond.cli", *arguments], capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize(
    ("command", "text", "expected"),
    [
        ("run", "[rod]\nlenght = 1", "rod.lenght: unknown key; did you mean 'length'?"),
        ("run", "[control]\nlaw = 'pid'", "control.law: no law is called 'pid'"),
        ("run", "[loop]\nperiod = 0", "loop.period = 0"),
        ("simulate", "[simulator]\nperiod = 0", "simulator.period = 0"),
        ("arm", "[bus]\nendpoint = 7447", "bus.endpoint = 7447"),
    ],
)
def test_a_wrong_configuration_is_refused_before_anything_starts(
    tmp_path: Path, command: str, text: str, expected: str
) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(text)
    result = run(command, "--config", str(file))
    assert result.returncode == 2
    assert result.stderr.startswith(f"tendond: {file}:")
    assert f": {expected}" in result.stderr
    assert "Traceback" not in result.stderr


def test_an_operator_without_a_controller_gets_one_line(tmp_path: Path) -> None:
    one = Rig(tmp_path)
    result = run("arm", "--config", str(one.config))
    assert result.returncode == 1
    assert result.stderr.count("\n") == 1
    assert "no controller at" in result.stderr


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys, contextlib, io\n"
        "from tendond.cli.app import app\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n    app(['--help'])\n"
        "print(sorted({'numpy', 'numba', 'zenoh', 'pydantic', 'matplotlib', 'mcap'} & set(sys.modules)))"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout.strip() == "[]"


def test_a_simulator_that_dies_in_lockstep_is_a_fault_and_the_tendons_are_released(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        controller = one.controller("--lockstep", "--arm-at", "5")
        simulator = one.start("simulate", "--lockstep")
        with one.session() as session:
            one.until(session, lambda s: s.mode is Mode.TRACKING)
            simulator.kill()
            status = one.until(session, lambda s: s.mode is Mode.FAULT and s.tension == (0.0,) * 4)
            assert "pose stale" in status.reason
        assert one.end(controller)[0] == 0


def test_a_signal_in_lockstep_releases_the_tendons_too(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        controller = one.controller("--lockstep", "--arm-at", "5")
        one.start("simulate", "--lockstep")
        with one.session() as session:
            one.until(session, lambda s: s.mode is Mode.TRACKING)
        assert one.end(controller)[0] == 0
    last = load(tmp_path / "run.mcap").records[-1]
    assert (last.tension_estimate, last.command.armed) == ((0.0,) * 4, False)


def test_a_simulator_that_waits_for_its_controller_ends_at_a_signal(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        port = int(one.endpoint.rpartition(":")[2])
        with socket.create_server(("127.0.0.1", port)) as refusing:
            refusing.settimeout(PATIENCE_SECONDS)
            simulator = one.start("simulate")
            refusing.accept()[0].close()  # it has looked for its controller
        code, said = one.end(simulator)
        assert code == 0
        assert "Traceback" not in said


def test_a_log_is_never_overwritten(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        (tmp_path / "run.mcap").write_text("precious")
        controller = one.controller()
        _, said = controller.communicate(timeout=60)
        assert controller.returncode == 1
        assert "run.mcap" in said
    assert (tmp_path / "run.mcap").read_text() == "precious"
