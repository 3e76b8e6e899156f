"""A cycle that fails: what leaves the process from then on lets the tendons out, in displacement as in tension."""

from pathlib import Path

import numpy as np
import pytest
import zenoh

from tendond.daemon.control.state import CycleState
from tendond.daemon.errors import DaemonError
from tendond.schemas.keys import TENDON_COMMAND, key
from tendond.schemas.messages import TendonCommand
from tendond.schemas.record import CycleInputs
from tendond.schemas.wire import decode
from tests.sil.loop.in_process import in_process

pytestmark = pytest.mark.sil

PULLED = 0.02
"""Displacement command of a tendon at which the cycle fails [m]."""


def test_the_ramp_of_a_crash_releases_pulled_tendons_steadily_to_zero(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(state: CycleState, inputs: CycleInputs) -> bool:
        return bool(state.displacement_command.max() > PULLED)

    error = RuntimeError("of all things")
    with in_process(tmp_path, monkeypatch, failing, error, limits={"release_rate": 200.0}) as one:
        subscriber = one.session.declare_subscriber(key(one.rig.name, TENDON_COMMAND), zenoh.handlers.FifoChannel(5000))
        with pytest.raises(DaemonError, match="of all things"):
            one.run()
        commands: list[TendonCommand] = []
        while not commands or commands[-1].armed or max(c.tension[0] for c in commands) == 0.0:
            commands.append(decode(TendonCommand, subscriber.recv().payload.to_bytes()))
    tension = np.array([command.tension for command in commands])
    displacement = np.array([command.displacement for command in commands])
    start = int(np.flatnonzero(displacement.max(axis=1) > PULLED)[0])
    ramp, pulled = displacement[start:], tension[start:, 0]
    assert len(ramp) > 10
    assert np.all(np.diff(ramp.max(axis=1)) <= 0.0)
    rate = one.config.with_own_rates().limits.displacement_rate
    assert np.abs(np.diff(ramp[:-1], axis=0)).max() <= rate * one.config.loop.period  # the last one is slack, disarmed
    assert ramp[:, 0] == pytest.approx(
        ramp[0, 0] * pulled / pulled[0], abs=1e-9
    )  # displacement and tension in proportion
    assert not ramp[-1].any()
