"""A cycle that fails: what leaves the process from then on lets the tendons out, in displacement as in tension."""

from pathlib import Path

import numpy as np
import pytest
import zenoh

from tendond.daemon.control.cycle import respond
from tendond.daemon.control.record import Response
from tendond.daemon.control.state import CycleSetup, CycleState
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.runtime import loop as loop_module
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.loop import Loop
from tendond.drivers.simulator.plant import Plant
from tendond.schemas.config.rig import check_config
from tendond.schemas.keys import TENDON_COMMAND, key
from tendond.schemas.messages import TendonCommand
from tendond.schemas.record import CycleInputs
from tendond.schemas.wire import decode
from tests.sil.pacer import PlantPacer
from tests.sil.rig import Rig

pytestmark = pytest.mark.sil

WOUND_UP = 0.02
"""[m] Of a tendon, at which the cycle fails."""


def test_the_ramp_of_a_crash_lets_the_wound_tendons_out_steadily_to_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(setup: CycleSetup, state: CycleState, inputs: CycleInputs) -> Response:
        if state.displacement_command.max() > WOUND_UP:
            raise RuntimeError("of all things")
        return respond(setup, state, inputs)

    one = Rig(tmp_path)
    config = check_config(
        {"rig": {"name": one.name}, "bus": {"endpoint": one.endpoint}, "limits": {"release_rate": 200.0}}, "test"
    )
    setup = CycleSetup.from_config(config)
    with Hub(config) as hub, RunLog(tmp_path / "run.mcap", config, setup.rod) as run_log, one.session() as session:
        subscriber = session.declare_subscriber(key(one.name, TENDON_COMMAND), zenoh.handlers.FifoChannel(5000))
        loop = Loop(setup, hub, run_log, arm_at=5)
        state = loop.warm()
        monkeypatch.setattr(loop_module, "respond", failing)
        with pytest.raises(DaemonError, match="of all things"):
            loop.run(state, PlantPacer(hub, Plant(config, setup.rod)), lambda: False)
        commands: list[TendonCommand] = []
        while not commands or commands[-1].armed or max(c.tension[0] for c in commands) == 0.0:
            commands.append(decode(TendonCommand, subscriber.recv().payload.to_bytes()))
    tension = np.array([command.tension for command in commands])
    displacement = np.array([command.displacement for command in commands])
    start = int(np.flatnonzero(displacement.max(axis=1) > WOUND_UP)[0])
    ramp, pulled = displacement[start:], tension[start:, 0]
    assert len(ramp) > 10
    assert np.all(np.diff(ramp.max(axis=1)) <= 0.0)
    rate = config.with_own_rates().limits.displacement_rate
    assert np.abs(np.diff(ramp[:-1], axis=0)).max() <= rate * config.loop.period  # the last one is slack, disarmed
    assert ramp[:, 0] == pytest.approx(ramp[0, 0] * pulled / pulled[0], abs=1e-9)  # as much is let out as is released
    assert not ramp[-1].any()
