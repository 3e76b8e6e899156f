"""A controller that fails while it pulls: its ramp reaches the servos, command by command."""

import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from tendond.drivers.dynamixel.emulator.protocol import Instruction, Packet
from tendond.drivers.dynamixel.serial import table
from tests.rig.chain import PATIENCE_SECONDS, Chain

pytestmark = [pytest.mark.rig, pytest.mark.sil]

FAILING = """
import sys
from tendond.cli.app import main
from tendond.daemon.control.cycle import respond
from tendond.daemon.runtime import loop

def failing(setup, state, inputs):
    if state.displacement_command.max() > 0.03:
        raise RuntimeError("made to fail")
    return respond(setup, state, inputs)

loop.respond = failing
main()
"""
"""`tendond`, with a cycle that fails once a tendon has been pulled by 30 mm."""


ADDRESS = table.GOAL_POSITION.address.to_bytes(2, "little")


@pytest.fixture
def chain(tmp_path: Path) -> Iterator[Chain]:
    one = Chain(tmp_path)
    try:
        yield one
    finally:
        one.close()


def goals_sent(packets: Sequence[Packet], servo: int) -> list[int]:
    """Return the different Goal Positions of a servo in Sync Writes, in order [ticks]."""
    goals: list[int] = []
    stride = 1 + table.GOAL_POSITION.size
    for packet in packets:
        data = packet.parameters
        if packet.instruction != Instruction.SYNC_WRITE or data[:2] != ADDRESS:
            continue
        for at in range(4, len(data), stride):
            goal = table.GOAL_POSITION.from_bytes(data[at + 1 : at + stride])
            if data[at] == servo and (not goals or goal != goals[-1]):
                goals.append(goal)
    return goals


def test_the_ramp_of_a_failed_controller_reaches_the_servos_and_ends_slack_and_off(chain: Chain) -> None:
    arguments = ["run", "--log", str(chain.folder / "run.mcap"), "--config", str(chain.config)]
    controller = subprocess.Popen(
        [sys.executable, "-c", FAILING, *arguments], cwd=chain.folder, stderr=subprocess.PIPE, text=True
    )
    chain.processes.append(controller)
    with chain.session() as session:
        chain.track(session, 0.02)
    deadline = time.monotonic() + PATIENCE_SECONDS
    while any(chain.torques):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    goals = goals_sent(chain.wired.bus.instructions, servo=1)
    _, said = controller.communicate(timeout=PATIENCE_SECONDS)
    assert controller.returncode == 1
    assert "the controller failed: RuntimeError: made to fail" in said
    chain.wait_for_slack_and_off()
    pulled = np.abs(np.array(goals) - 2048) / table.TICKS_PER_TURN * 2.0 * np.pi * 0.015
    ramp = pulled[int(np.argmax(pulled)) :]
    assert ramp[0] == pytest.approx(0.03, abs=0.005)
    assert len(ramp) > 20
    assert np.all(np.diff(ramp) <= 0.0)
    assert ramp[-1] < 0.001
    limits = chain.settings.with_own_rates().limits
    gradual = -4.0 * limits.displacement_rate * chain.settings.loop.period  # a late driver sends a few commands as one
    assert float(np.min(np.diff(ramp))) >= gradual
    code, said = chain.end(chain.drivers["servo"])
    assert code == 0
    assert "out of order" not in said  # none of the ramp's commands was dropped
