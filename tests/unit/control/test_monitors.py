"""Monitors while tracking: each anomaly becomes a fault of its own name, and no right run does."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np
import pytest

from tendond.daemon.control.commissioning.jump import POSES_AFTER, JumpWatch, watch_jump
from tendond.daemon.control.commissioning.swing import Swing
from tendond.daemon.control.commissioning.tracking import TrackingBounds, TrackingWatch, tracking_fault, watch_tracking
from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.drivers.simulator.lockstep import STRAIGHT, Wires, watched_loop
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction

ARM, SETTLED = 20, 250
BOUNDS = TrackingBounds.from_config(RigConfig())
NOISE = "[simulator.mocap]\nnoise = 1e-4\n"


def run(text: str, wires: Wires = STRAIGHT, cycles: int = 900) -> list[CycleRecord]:
    """In lockstep, armed at `ARM`, until a fault."""
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
    way = tuple((size * np.eye(3)[axis]).tolist())
    records = run(NOISE, moved(way, SETTLED))
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
    quiet, hit = run(text), run(text, moved((0.0, 0.0, 0.1), SETTLED, SETTLED + 1))
    assert hit[-1].mode is quiet[-1].mode
    if quiet[-1].mode is Mode.TRACKING:
        tension = np.array([record.command.tension for record in hit[SETTLED - 20 : SETTLED + 30]])
        assert np.ptp(tension, axis=0).max() < 0.1 * RigConfig().limits.tension_max


@pytest.mark.parametrize("axis", [0, 2])
def test_a_drift_of_a_hundred_millimetres_does_not_go_unnoticed(axis: int) -> None:
    def pose(tick: int, pose: TipPose | None) -> TipPose | None:
        if pose is None:
            return None
        way = 0.025 * 0.01 * max(0, tick - SETTLED) * np.eye(3)[axis]
        x, y, z = np.add(pose.position, way).tolist()
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


def test_poses_as_old_as_the_observer_is_told_are_none_the_worse() -> None:
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


def test_a_swing_that_goes_on_is_found_with_its_size_and_frequency() -> None:
    swing = Swing()
    for tick in range(600):
        swing = swing.add(0.05 * math.sin(2.0 * math.pi * 2.0 * 0.01 * tick), tick, BOUNDS.swing)
    found = swing.sustained(0.01)
    assert found is not None
    assert found[0] == pytest.approx(0.1, rel=0.01)
    assert found[1] == pytest.approx(2.0, rel=0.05)


@pytest.mark.parametrize("ratio", [0.03, 0.16])
def test_a_swing_that_dies_down_or_is_small_is_none(ratio: float) -> None:
    dying, small = Swing(), Swing()
    for tick in range(2000):
        phase = 2.0 * math.pi * 1.0 * 0.01 * tick
        dying = dying.add(0.1 * math.exp(-ratio * phase) * math.cos(phase), tick, BOUNDS.swing)
        small = small.add(0.4 * BOUNDS.swing * math.cos(phase), tick, BOUNDS.swing)
        assert dying.sustained(0.01) is None
        assert small.sustained(0.01) is None


def test_swings_with_a_rest_between_them_are_no_limit_cycle() -> None:
    """A start that rings six times, five seconds of rest, and a push that makes the arm ring again."""
    swing = Swing()
    for tick in range(1400):
        now = 0.01 * tick
        ringing = now < 3.0 or now > 8.0
        value = 0.1 * math.exp(-0.1 * (now if now < 3.0 else now - 8.0)) * math.cos(2.0 * math.pi * 1.1 * now)
        swing = swing.add(value if ringing else 0.0, tick, BOUNDS.swing)
        if now < 12.0:
            assert swing.sustained(0.01) is None
    assert swing.sustained(0.01) is not None  # the second ringing alone has lasted long enough by now


def test_a_swing_that_dies_down_and_is_pushed_again_is_no_limit_cycle_and_a_growing_one_is() -> None:
    pushed, growing = Swing(), Swing()
    for tick in range(900):
        now = 0.01 * tick
        since = now % 3.5  # a push each 3.5 s, of which a tenth is left when the next one comes
        pushed = pushed.add(0.1 * math.exp(-0.65 * since) * math.cos(2.0 * math.pi * 2.0 * since), tick, BOUNDS.swing)
        growing = growing.add(0.02 * math.exp(0.3 * now) * math.cos(2.0 * math.pi * 2.0 * now), tick, BOUNDS.swing)
        assert pushed.sustained(0.01) is None, (tick, pushed)
        if now > 4.5:
            assert growing.sustained(0.01) is not None, (tick, growing)


def swung(position: Callable[[float], float], velocity: Callable[[float], Vector3], seconds: float) -> str:
    """Watch a tip that is off its reference in x [m], while that moves [m/s]."""
    watch, still = TrackingWatch(), (0.0, 0.0, 0.0)
    for tick in range(round(seconds / 0.01)):
        now = 0.01 * tick
        tip = (position(now), 0.0, 0.0)
        watch = watch_tracking(BOUNDS, watch, tick, 1, tip, still, velocity(now), (0.0,) * 4, 0.0)
        if found := tracking_fault(BOUNDS, watch, saturated=False):
            return found
    return ""


def test_a_tip_that_swings_as_its_reference_does_is_not_the_loops_fault() -> None:
    """A chirp that the tip follows late, and a reference that starts and stops twice in a second."""

    def sway(now: float) -> float:
        return 0.04 * math.sin(2.0 * math.pi * 2.0 * now)

    def back_and_forth(now: float) -> Vector3:
        return (0.3 * math.cos(2.0 * math.pi * 2.0 * now), 0.0, 0.0)

    def steps(now: float) -> Vector3:
        return (0.1 if now % 1.0 < 0.4 else 0.0, 0.0, 0.0)

    assert swung(sway, back_and_forth, 20.0) == ""
    assert swung(sway, steps, 20.0) == ""


@pytest.mark.parametrize("turning", [0.0, 0.3])
def test_a_swing_about_a_reference_that_rests_or_goes_round_is_a_limit_cycle(turning: float) -> None:
    def round_and_round(now: float) -> Vector3:
        angle = 2.0 * math.pi * 0.3 * now
        return (turning * math.cos(angle), turning * math.sin(angle), 0.0)

    found = swung(lambda now: 0.04 * math.sin(2.0 * math.pi * 2.0 * now), round_and_round, 5.0)
    assert found.startswith("limit cycle: the tip swings by 80 mm in x at 2.0 Hz")


def test_a_blow_is_no_jump_and_a_jump_is_none_while_the_tip_moves() -> None:
    watch = JumpWatch()
    for way in (0.0, 0.001, 0.03, 0.05, 0.04, 0.01):  # it goes on moving
        watch = watch_jump(BOUNDS, watch, 1, way, way, (0.0, 0.0, 0.5))
        assert not watch.persistent
    watch = JumpWatch()
    for way in (0.0, 0.001, 0.03, *(0.0005,) * POSES_AFTER):
        watch = watch_jump(BOUNDS, watch, 1, way, way, (0.0, 0.0, 0.5))
    assert watch.persistent


def test_an_arm_that_springs_back_after_a_push_of_one_cycle_has_not_jumped() -> None:
    """The turning point is one small step; a push of 10 N on an arm with stiff tendons, as the simulator has it."""
    watch = JumpWatch()
    for way in (0.0, 0.0003, 0.0176, 0.005, 0.0095, 0.0098, 0.0057, 0.003, 0.0018):
        watch = watch_jump(BOUNDS, watch, 1, way, way, (0.0, 0.0, 0.5))
        assert not watch.persistent


def test_poses_that_were_held_up_are_no_jump_when_they_come_at_once() -> None:
    """The first of seven after a gap, then the newest of the rest: six ways in one cycle."""
    watch = JumpWatch()
    for interval, way in ((1, 0.006), (1, 0.006), (7, 0.006), (1, 0.036), (1, 0.006), (1, 0.006)):
        watch = watch_jump(BOUNDS, watch, interval, way, way, (0.0, 0.0, 0.5))
        assert not watch.withheld
        assert not watch.persistent
    watch = JumpWatch()
    still = ((1, 0.001),) * POSES_AFTER
    for interval, way in ((1, 0.001), (7, 0.006), (1, 0.3), *still):  # further than any arm gets in the time
        watch = watch_jump(BOUNDS, watch, interval, way, way, (0.0, 0.0, 0.5))
    assert watch.persistent


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


def test_a_pose_after_missed_deadlines_is_no_jump() -> None:
    """While the controller stood still the arm went on, and the model did not."""
    setup = CycleSetup.from_config(parse_config("[commissioning]\nrest = false\nprobe = false\n", "test"))
    state = initial_state(setup)
    for tick, missed in enumerate((0, 0, 6, 0)):
        x = 0.0 if tick < 2 else 0.12
        pose = TipPose(seq=tick, stamp_ns=0, position=(x, 0.0, 0.48), orientation=(1.0, 0.0, 0.0, 0.0))
        request = ControlAction.ARM if tick == 1 else None
        state, _, record = step(setup, state, CycleInputs(pose=pose, missed_ticks=missed, request=request))
        assert not state.jump_watch.withheld
    assert record.mode is not Mode.FAULT
