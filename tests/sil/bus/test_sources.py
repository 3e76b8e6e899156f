"""A left-over simulator, and a second controller of the same rig: named, and refused or a fault."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import zenoh

from tendond.schemas.keys import TIP_POSE
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.sil.bus.live import Live
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig

pytestmark = pytest.mark.sil


def test_a_left_over_simulator_keeps_the_rig_from_arming_and_is_a_fault_while_armed(live: Live) -> None:
    one, session = live.rig, live.session
    second = one.start("simulate")
    status = one.until(session, lambda status: len(status.sources.get(TIP_POSE, ())) == 2)
    reply = one.ask(session, ControlAction.ARM)
    assert not reply.done
    assert "two sources of tip/pose: 'simulator-" in reply.message
    assert all(name in reply.message for name in status.sources[TIP_POSE])
    one.end(second)
    one.until(session, lambda status: len(status.sources[TIP_POSE]) == 1)
    one.arm(session)
    third = one.start("simulate")
    status = one.until(session, lambda status: status.mode is Mode.FAULT)
    assert "two sources of tip/pose: 'simulator-" in status.reason
    assert live.simulator.poll() is None
    one.end(third)
    one.until(session, lambda status: len(status.sources[TIP_POSE]) == 1)


def test_an_identification_beside_a_running_controller_is_refused(live: Live, tmp_path: Path) -> None:
    log = tmp_path / "run.mcap"
    refused = live.rig.command("identify", "run", "--log", str(log), "--parts", "steps", "--yes")
    assert refused.returncode == 2
    assert "a controller runs at" in refused.stderr
    assert not log.exists()
    assert live.rig.status(live.session).mode is Mode.IDLE


def router(endpoint: str) -> zenoh.Session:
    settings = zenoh.Config()
    settings.insert_json5("mode", '"router"')
    settings.insert_json5("listen/endpoints", json.dumps([endpoint]))
    settings.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(settings)


def test_a_second_controller_of_the_same_rig_on_another_endpoint_ends_and_names_the_first(tmp_path: Path) -> None:
    for name in ("a", "b", "hub"):
        (tmp_path / name).mkdir()
    hub = Rig(tmp_path / "hub").endpoint
    (tmp_path / "connect.json5").write_text(json.dumps({"connect": {"endpoints": [hub]}}))
    environment = {**os.environ, "ZENOH_CONFIG": str(tmp_path / "connect.json5")}

    def controller(one: Rig) -> "subprocess.Popen[str]":
        text = one.config.read_text()
        one.config.write_text(text.replace("[bus]\n", "[bus]\nunguarded = true\n"))
        process = subprocess.Popen(
            [sys.executable, "-m", "tendond.cli", "run", "--config", str(one.config)],
            cwd=one.folder, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        one.processes.append(process)
        return process

    with router(hub), rig(tmp_path / "a") as first, rig(tmp_path / "b") as other:
        running = controller(first)
        with first.session() as session:
            first.status(session)
            started = time.monotonic()
            second = controller(other)
            _, said = second.communicate(timeout=PATIENCE_SECONDS)
            assert second.returncode == 1, said
            lines = [line for line in said.splitlines() if "has a controller already" in line]
            assert len(lines) == 1
            assert "'controller-" in lines[0]
            assert "Traceback" not in said
            status = first.status(session)
            assert running.poll() is None
            assert status.mode is Mode.IDLE
            assert time.monotonic() - started < PATIENCE_SECONDS
