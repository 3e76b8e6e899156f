"""A run of the law `policy`: its log has the weights, and replays to the last bit without the policy's file."""

import json
from pathlib import Path

import numpy as np
import pytest

from tendond.cli.common import load_config
from tendond.daemon.control.laws.policy import KINEMATIC
from tendond.daemon.control.setup import CycleSetup
from tendond.offline.learning.policy_file import save_policy
from tendond.offline.logs.run import open_run
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.unit.logs.commands import run_command
from tests.unit.logs.logs import rewritten
from tests.unit.offline.learning.test_onnx_file import CHAINS, written

RIG = """\
[rod]
nodes = 6
[simulator.mocap]
noise = 1e-4
[commissioning]
probe = false
[control]
law = "policy"
[control.laws.policy]
file = "policy.{kind}"
rate = 20.0
"""


@pytest.mark.parametrize("kind", ["npz", "onnx"])
def test_a_run_replays_to_the_last_bit_from_its_log_alone(kind: str, tmp_path: Path) -> None:
    policy, log, rig = tmp_path / f"policy.{kind}", tmp_path / "run.mcap", tmp_path / "rig.toml"
    random = np.random.default_rng(3)
    if kind == "npz":
        layers = [(random.normal(0.0, 0.3, (8, KINEMATIC + 4)), np.zeros(8)), (random.normal(size=(4, 8)), np.zeros(4))]
        save_policy(policy, layers, length=0.5, tension=60.0, rate=200.0)
    else:
        written(policy, CHAINS["as PyTorch exports a multilayer perceptron"])
    rig.write_text(RIG.format(kind=kind))
    records = record_lockstep(CycleSetup.from_config(load_config(rig)), 60, {5: ControlAction.ARM}, log)
    policy.unlink()
    outputs = {one.wanted for one in records if one.mode is Mode.TRACKING}
    assert len(outputs) > 10  # it reacts, so that a policy with other weights is another run

    said = run_command("log", "replay", str(log))
    assert said.returncode == 0, said.stdout + said.stderr

    config = json.loads(open_run(log).config.model_dump_json())
    for row in config["control"]["laws"]["policy"]["layers"][0]["weights"]:
        row[0] *= 1.0 + 1e-12
    other = rewritten(log, tmp_path / "other.mcap", config=json.dumps(config))
    assert run_command("log", "replay", str(other)).returncode == 1
