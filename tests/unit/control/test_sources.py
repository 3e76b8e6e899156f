"""One source of poses, one of tendon states, one controller: a second one is named, and refused or a fault."""

from typing import Any

import pytest

from tendond.bus.followed import FollowedController
from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.schemas.keys import ALIVE, TENDON_STATE, TIP_POSE
from tendond.schemas.messages import Mode, TendonCommand, TendonState, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import CONFIG, REST, UPRIGHT

UNCHECKED = CONFIG.commissioning.model_copy(update={"rest": False})
SETUP = CycleSetup.from_config(CONFIG.model_copy(update={"commissioning": UNCHECKED}))
"""Rests are compared after some poses; here arming is to depend on sources alone."""
FOUR = (0.0,) * 4


class Bench:
    """The cycle, fed by hand with messages of named sources."""

    def __init__(self) -> None:
        self.state: CycleState = initial_state(SETUP)
        self.counts: dict[str, int] = {}

    def pose(self, source: str, start: int = 1) -> TipPose:
        self.counts[source] = self.counts.get(source, start - 1) + 1
        return TipPose(seq=self.counts[source], stamp_ns=0, position=REST, orientation=UPRIGHT, source=source)

    def tendons(self, source: str) -> TendonState:
        name = f"{source}/t"
        self.counts[name] = self.counts.get(name, 0) + 1
        return TendonState(seq=self.counts[name], stamp_ns=0, displacement=FOUR, tension=FOUR, source=source)

    def go(self, **inputs: Any) -> CycleRecord:
        self.state, _, record = step(SETUP, self.state, CycleInputs(**inputs))
        return record

    def arm(self) -> CycleRecord:
        return self.go(request=ControlAction.ARM)


def test_a_second_source_of_poses_is_refused_and_arming_names_both() -> None:
    bench = Bench()
    for _ in range(5):
        bench.go(pose=bench.pose("simulator-1"))
    record = bench.go(pose=bench.pose("vicon-2", start=1000))
    assert record.rejected == ("another source",)
    bench.go(pose=bench.pose("simulator-1"))
    assert bench.state.pose is not None
    assert bench.state.pose.source == "simulator-1"
    assert bench.arm().reply == ("not armed: two sources of tip/pose: 'simulator-1' and 'vicon-2': end one of them")


def test_a_second_source_that_is_gone_for_a_while_does_not_keep_from_arming() -> None:
    bench = Bench()
    bench.go(pose=bench.pose("vicon-1"))
    bench.go(pose=bench.pose("simulator-2"))
    for _ in range(SETUP.thresholds.source_time + 2):
        bench.go(pose=bench.pose("vicon-1"))
    assert bench.arm().accepted


@pytest.mark.parametrize("topic", [TIP_POSE, TENDON_STATE, ALIVE])
def test_a_second_source_or_controller_while_armed_is_a_fault_that_names_it(topic: str) -> None:
    bench = Bench()
    for _ in range(3):
        bench.go(pose=bench.pose("vicon-1"), tendon_state=bench.tendons("servo-1"))
    assert bench.arm().accepted
    bench.go(pose=bench.pose("vicon-1"), tendon_state=bench.tendons("servo-1"))
    record = bench.go(pose=bench.pose("vicon-1"), tendon_state=bench.tendons("servo-1"), others={topic: "intruder-9"})
    assert record.mode is Mode.FAULT
    assert "'intruder-9'" in record.reason


def test_a_driver_that_was_restarted_while_idle_is_taken_up_after_the_old_one_fell_silent() -> None:
    bench = Bench()
    for _ in range(50):
        bench.go(pose=bench.pose("vicon-1", start=9000), tendon_state=bench.tendons("servo-1"))
    for _ in range(SETUP.thresholds.tendon_timeout + 2):
        bench.go()
    record = bench.go(pose=bench.pose("vicon-2"), tendon_state=bench.tendons("servo-2"))
    assert record.rejected == ()
    assert bench.arm().accepted


def test_another_source_is_never_taken_up_while_tendons_are_pulled() -> None:
    bench = Bench()
    for _ in range(3):
        bench.go(pose=bench.pose("vicon-1"))
    assert bench.arm().accepted
    for _ in range(SETUP.thresholds.pose_timeout - 1):
        bench.go()
    record = bench.go(pose=bench.pose("vicon-2"))
    assert record.mode is Mode.FAULT
    assert record.rejected == ("another source",)
    assert bench.state.pose is not None
    assert bench.state.pose.source == "vicon-1"


def test_two_publishers_without_names_are_distinguished_by_their_counts() -> None:
    bench = Bench()
    seen: set[str] = set()
    for tick in range(2 * SETUP.thresholds.pose_timeout):
        pose = TipPose(seq=tick + (5000 if tick % 2 else 0), stamp_ns=0, position=REST, orientation=UPRIGHT)
        seen.update(bench.go(pose=pose).rejected)
    assert seen == {"count starts anew"}
    assert bench.arm().reply == (
        "not armed: two sources of tip/pose: one without a name and one without a name: end one of them"
    )


def test_a_driver_without_a_name_that_starts_anew_is_called_that_and_then_taken_up() -> None:
    bench = Bench()
    for seq in range(1000, 1010):
        bench.go(pose=TipPose(seq=seq, stamp_ns=0, position=REST, orientation=UPRIGHT))
    rejected = []
    for seq in range(SETUP.thresholds.pose_timeout + 40):
        record = bench.go(pose=TipPose(seq=seq, stamp_ns=0, position=REST, orientation=UPRIGHT))
        rejected.append(record.rejected)
    assert set(rejected[: SETUP.thresholds.pose_timeout]) == {("count starts anew",)}
    assert rejected[-1] == ()
    assert bench.arm().accepted


def command(source: str, armed: bool = False) -> TendonCommand:
    return TendonCommand(seq=1, stamp_ns=0, pose_seq=None, displacement=FOUR, tension=FOUR, armed=armed, source=source)


def test_a_driver_follows_the_first_controller_and_names_the_other() -> None:
    followed = FollowedController()
    assert followed.admits(command("controller-a"), 0.0)
    assert not followed.admits(command("controller-b", armed=True), 0.1)
    assert followed.admits(command("controller-a"), 0.2)
    assert followed.objection(0.3) == (
        "commands of two controllers: 'controller-a' is followed, 'controller-b' is not; stop one"
    )
    assert followed.objection(1.2) == ""


def test_a_driver_takes_up_another_controller_once_the_first_is_gone() -> None:
    followed = FollowedController()
    assert followed.admits(command("controller-a"), 0.0)
    assert not followed.admits(command("controller-b"), 0.9)
    assert followed.admits(command("controller-b"), 1.1)
    assert followed.objection(1.1) == ""
