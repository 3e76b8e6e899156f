"""Monitors while tracking: each anomaly becomes a fault of its own name, and no right run does."""

from collections import deque

import numpy as np
import pytest

from tendond.daemon.control.commissioning.jump import POSES_AFTER
from tendond.drivers.simulator.lockstep import STRAIGHT, Wires, watched_loop
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

ARM, SETTLED = 20, 250
NOISE = "[simulator.mocap]\nnoise = 1e-4\n"


def run(text: str, wires: Wires = STRAIGHT, cycles: int = 900) -> list[CycleRecord]:
    """Run in lockstep, armed at `ARM`, until a fault."""
    records = []
    for watched in watched_loop(parse_config(text, "test"), cycles, {ARM: ControlAction.ARM}, wires=wires):
        records.append(watched.record)
        if watched.record.mode is Mode.FAULT:
            break
    return records


def moved(displacement: tuple[float, float, float], first: int, last: int = 10**9) -> Wires:
    """Poses displaced [m] from a tick on, until another."""

    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        if pose is None or not first <= tick < last:
            return pose
        x, y, z = np.add(pose.position, displacement).tolist()
        return pose.model_copy(update={"position": (x, y, z)})

    return Wires(pose=pose)


def late(cycles: int, first: int = 0) -> Wires:
    """Poses that wait, from a tick on."""
    queue: deque[TipPose | None] = deque()

    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        queue.append(pose)
        if tick < first:
            return queue.popleft()
        return queue.popleft() if len(queue) > cycles else None

    return Wires(pose=pose)


@pytest.mark.parametrize("size", [0.03, 0.1, -0.03])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_tip_that_jumps_and_stays_is_a_fault_at_once(size: float, axis: int) -> None:
    offset = tuple((size * np.eye(3)[axis]).tolist())
    records = run(NOISE, moved(offset, SETTLED))
    assert records[-1].mode is Mode.FAULT
    assert records[-1].reason.startswith(f"pose jump: the measured tip went {abs(size) * 1e3:.0f} mm between two poses")
    assert records[-1].tick - SETTLED <= 1 + POSES_AFTER
    pulled = [record.command.tension[0] for record in records[SETTLED - 5 :]]
    assert max(pulled) - pulled[0] < 1.0  # nobody has followed it


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode", "sensitivity"])
@pytest.mark.parametrize("feedback", ["observer", "direct"])
def test_a_single_jump_is_not_followed(law: str, feedback: str) -> None:
    if law == "sensitivity" and feedback == "direct":
        pytest.skip("the law looks ahead with the model")
    text = f'{NOISE}[control]\nlaw = "{law}"\nfeedback = "{feedback}"\n'
    plain, hit = run(text), run(text, moved((0.0, 0.0, 0.1), SETTLED, SETTLED + 1))
    assert hit[-1].mode is plain[-1].mode
    if plain[-1].mode is Mode.TRACKING:
        tension = np.array([record.command.tension for record in hit[SETTLED - 20 : SETTLED + 30]])
        assert np.ptp(tension, axis=0).max() < 0.1 * RigConfig().limits.tension_max


@pytest.mark.parametrize("axis", [0, 2])
def test_a_drift_of_a_hundred_millimetres_does_not_go_unnoticed(axis: int) -> None:
    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        offset = 0.025 * 0.01 * max(0, tick - SETTLED) * np.eye(3)[axis]
        x, y, z = np.add(pose.position, offset).tolist()
        return pose.model_copy(update={"position": (x, y, z)})

    records = run(NOISE, Wires(pose=pose))
    assert records[-1].mode is Mode.FAULT, "not noticed"
    assert (records[-1].tick - SETTLED) * 0.01 < 6.0


@pytest.mark.parametrize("cycles", [10, 20, 30, 50])
def test_poses_that_have_waited_are_refused_before_arming_and_a_fault_afterwards(cycles: int) -> None:
    asked = run("", late(cycles), 100)
    assert asked[ARM].mode is not Mode.TRACKING
    if cycles < ARM:
        assert "ms old, where observer.delay and faults.pose_age allow 50 ms" in asked[ARM].reply
    records = run(NOISE, late(cycles, SETTLED), SETTLED + 200)
    assert records[-1].mode is Mode.FAULT
    assert records[-1].reason.startswith(("pose age: poses are", "pose stale"))


def test_poses_as_old_as_configured_are_none_the_worse() -> None:
    text = "[observer]\ndelay = 0.06\n[simulator.mocap]\nlatency = 0.06\n[reference]\nkind = 'minimum_jerk'\n"
    assert run(text, cycles=300)[-1].mode is Mode.TRACKING


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"tension": (300.0, 0.0, 0.0, 0.0)}, "tendon 0 reports 300 N, where limits.tension_max is 60 N"),
        ({"tension": (50.0, 0.0, 40.0, 0.0)}, "tendon 2 reports 40 N, where the model has 0 N"),
        ({"displacement": (0.05, 0.0, 0.0, 0.5)}, "tendon 3 reports 500 mm, far beyond"),
    ],
)
def test_a_report_that_cannot_be_is_a_fault(change: dict[str, tuple[float, ...]], words: str) -> None:
    def report(state: TendonState) -> TendonState:
        return state.model_copy(update=change) if state.seq > SETTLED else state

    records = run("", Wires(report=report), SETTLED + 50)
    assert records[-1].mode is Mode.FAULT
    assert records[-1].reason.startswith(f"tendon report: {words}")


def test_an_arm_that_is_held_far_from_its_target_is_a_tracking_error() -> None:
    """A target that the limits do not let it reach: all is well but for that it never arrives."""
    held: list[TipPose] = []

    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        held.append(pose)
        x, y, z = held[0].position
        return pose.model_copy(update={"position": (x + 1e-4 * (tick % 2), y, z), "orientation": held[0].orientation})

    text = "[reference]\nacross = 0.15\n[limits]\nlimit_time = 100.0\n[faults]\nmismatch = 9.0\norientation = 9.0\n"
    text += "tension_swing = 9.0\n"
    records = run(text, Wires(pose=pose))
    assert records[-1].reason.startswith("tracking error: the tip is ")
    assert "is the arm held" in records[-1].reason


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode", "sensitivity"])
@pytest.mark.parametrize("stiffness", [0.8, 1.0, 1.2])
@pytest.mark.parametrize("kind", ["exponential", "step"])
def test_no_right_run_is_a_fault_however_fast(law: str, stiffness: float, kind: str) -> None:
    text = (
        f'[control]\nlaw = "{law}"\n[simulator.rod]\nyoungs_modulus = {190e9 * stiffness}\n'
        f'[reference]\nkind = "{kind}"\n{NOISE}latency = 0.01\n'
    )
    records = run(text, cycles=500)
    assert records[-1].mode is Mode.TRACKING, records[-1].reason
