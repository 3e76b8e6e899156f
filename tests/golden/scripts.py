"""The runs of the golden logs: controller and plant in lockstep, with an operator and, in one, all that goes wrong."""

from collections.abc import Callable
from pathlib import Path

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.plant import Plant
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.rig.servos import calibration

FOLDER = Path(__file__).parent
CYCLES = 190
EPOCH_NS = 1_700_000_000_000_000_000

CONFIG = """\
[rod]
nodes = 6
[simulator.rod]
nodes = 6
youngs_modulus = 180e9
[simulator.mocap]
noise = 2e-4
latency = 0.01
[control]
antagonist = 2
[pretension]
antagonist = 0.5
[limits]
release_rate = 200.0
[commissioning]
probe = false
[log]
shape_period = 20
"""

Spoil = Callable[[int, CycleInputs], CycleInputs]


def as_it_comes(tick: int, inputs: CycleInputs) -> CycleInputs:
    """Arm, track, stop."""
    requests = {5: ControlAction.ARM, 150: ControlAction.STOP}
    return inputs.model_copy(update={"request": requests.get(tick)})


def with_faults(tick: int, inputs: CycleInputs) -> CycleInputs:
    """Bad poses of every kind, a gap that the observer bridges, one that it does not; reset; a servo's fault."""
    update: dict[str, object] = {"request": {5: ControlAction.ARM, 70: ControlAction.ARM, 125: ControlAction.RESET,
                                             160: ControlAction.ARM}.get(tick)}  # fmt: skip
    pose, tendons = inputs.pose, inputs.tendon_state
    if pose is not None:
        if tick in (2, 40):
            pose = pose.model_copy(update={"valid": False})
        elif tick == 45:
            pose = pose.model_copy(update={"position": (0.2, 0.2, 0.2)})
        elif tick == 50:
            pose = pose.model_copy(update={"seq": 1})
        elif tick == 52:
            pose = pose.model_copy(update={"position": (3.0, 0.0, 0.0)})
        elif 55 <= tick < 60 or 75 <= tick < 100:
            pose = None
    if tick == 62:
        update["unreadable"] = {"malformed": 2, "not finite": 1}
    if tick == 64:
        update["missed_ticks"] = 2
    if tendons is not None and tick >= 182:
        tendons = tendons.model_copy(update={"fault": "servo 2: overload"})
    return inputs.model_copy(update={**update, "pose": pose, "tendon_state": tendons})


RUNS: dict[str, Spoil] = {"normal": as_it_comes, "faults": with_faults}


def record(name: str, path: Path) -> RigConfig:
    """Run one of them and write its log at `path`."""
    config = parse_config(CONFIG, "golden")
    setup = CycleSetup.from_config(config)
    plant = Plant(config, rod_from_section(config.simulator.rod, config.simulator.period))
    state = initial_state(setup)
    now_ns = [EPOCH_NS]
    calibrated = calibration(rig=config.rig.name)
    with RunLog(path, config, setup.rod, now=lambda: now_ns[0], queue=100_000, calibration=calibrated) as run_log:
        run_log.state(state)
        for tick in range(CYCLES):
            now_ns[0] = EPOCH_NS + round(tick * config.loop.period * 1e9)
            pose, tendon_state, truth = plant.observe(now_ns[0])
            inputs = RUNS[name](tick, CycleInputs(pose=pose, tendon_state=tendon_state))
            state, command, one = step(setup, state, inputs)
            run_log.cycle(one, None, state.rod, truth)
            run_log.state(state)
            plant.step(command)
    assert not run_log.error
    assert not run_log.dropped
    return config
