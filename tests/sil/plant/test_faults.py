"""Faults of what the controller is sent, by a scripted peer over real Zenoh; one process is used for most of them."""

import itertools
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tendond.offline.logs.log import load
from tendond.schemas.config.rig import parse_config
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.requests import ControlAction
from tests.sil.bench import ControllerBench, changed_briefly, frozen, moved, once
from tests.sil.peer import Outgoing, Peer
from tests.sil.rig import rig

pytestmark = pytest.mark.sil

BAD = {
    "not finite": b'{"version":1,"seq":1,"stamp_ns":0,"position":[NaN,0,0],"orientation":[1,0,0,0]}',
    "bad quaternion": b'{"version":1,"seq":1,"stamp_ns":0,"position":[0,0,0],"orientation":[1,1,0,0]}',
    "malformed": b"{",
    "wrong version": b'{"version":9,"seq":1,"stamp_ns":0,"position":[0,0,0],"orientation":[1,0,0,0]}',
    "too large": b"x" * 10_000_000,
    "deleted": None,
}

TOO_STRONG = """
[limits]
tension_max = 500.0
displacement_max = 1.0
displacement_min = -1.0
displacement_rate = 1000.0
release_rate = 1000.0
[pretension]
tension = 400.0
duration = 1.0
[reference]
unreachable = "track"
[faults]
mismatch = 100.0
frozen_distance = 1000.0
pose_timeout = 5.0
tendon_timeout = 5.0
overrun_time = 5.0
"""
"""400 N pull the paper's rod further than the solver can follow, however many poses are late."""


def test_single_bad_messages_are_dropped_and_counted_while_it_tracks_on(bench: ControllerBench) -> None:
    bench.track()
    before = bench.status()
    for payload in (*BAD.values(), b""):
        left = [payload]
        bench.peer.alter = once(left)
        while left:
            time.sleep(0.01)
    wanted = dict.fromkeys(BAD, 1) | {"malformed": 2}
    after = bench.rig.until(
        bench.session,
        lambda s: all(s.rejected.get(name, 0) - before.rejected.get(name, 0) == n for name, n in wanted.items()),
    )
    assert after.mode is Mode.TRACKING


def test_single_wrong_poses_are_dropped_and_counted_while_it_tracks_on(bench: ControllerBench) -> None:
    bench.track()
    held: list[TipPose] = []

    def late_and_duplicate(pose: TipPose) -> Outgoing:
        """Each pose a period late and the one before it after it."""
        held.append(pose)
        if len(held) < 4:
            yield pose
        elif len(held) == 4:
            yield pose
            yield pose
            yield held[0]
        else:
            yield pose

    before = bench.status().rejected
    bench.peer.alter = late_and_duplicate
    bench.rig.until(bench.session, lambda s: s.rejected.get("out of order", 0) >= before.get("out of order", 0) + 2)
    wrong: dict[str, dict[str, Any]] = {
        "teleport": {"position": (0.0, 0.6, 0.0)},
        "out of reach": {"position": (0.0, 3.0, 0.0)},
        "occluded": {"valid": False},
    }
    for reason, change in wrong.items():
        wanted = before.get(reason, 0) + 1
        bench.peer.alter = changed_briefly(change)
        bench.await_rejected(reason, wanted)
    assert bench.status().mode is Mode.TRACKING


@pytest.mark.parametrize(
    ("alter", "reason"),
    [
        (lambda pose: [], "pose stale: none accepted for "),
        (lambda pose: [b"{"], "bad poses: "),
        (
            lambda pose: [moved(pose, (pose.position[0], pose.position[1] + 0.5, pose.position[2]))],
            "teleport: poses beyond ",
        ),
        (lambda pose: [pose.model_copy(update={"valid": False})], "occluded: the tip was not seen for "),
        (lambda pose: [pose.model_copy(update={"seq": 3})], "bad poses: "),
        (lambda pose: [None], "bad poses: "),
    ],
    ids=["stale", "malformed", "teleport", "occluded", "old numbers", "deleted"],
)
def test_a_burst_releases_the_tendons_and_is_a_fault(
    bench: ControllerBench, alter: Callable[[TipPose], Outgoing], reason: str
) -> None:
    bench.track()
    bench.peer.alter = alter
    assert bench.fault().startswith(reason)


def test_frozen_poses_while_the_model_moves_are_a_fault(bench: ControllerBench) -> None:
    bench.track(alter=frozen())
    assert bench.fault().startswith("pose frozen: ")


def test_another_robot_than_the_model_is_a_fault(bench: ControllerBench) -> None:
    """Poses that wander off to where no speed or reach forbids the tip to be, but the model's tip is not."""
    ticks = itertools.count()

    def wander(pose: TipPose) -> Outgoing:
        x, y, z = pose.position
        yield moved(pose, (x, y + 0.25 * (1.0 - 0.98 ** next(ticks)), z - 0.4 * (1.0 - 0.98 ** next(ticks))))

    bench.track(alter=wander)
    reason = bench.fault()
    assert reason.startswith("mismatch: "), reason


def test_a_servo_error_is_a_fault_that_names_it_and_lasts_until_it_is_gone(bench: ControllerBench) -> None:
    bench.track()

    def sick(state: TendonState) -> Outgoing:
        yield state.model_copy(update={"fault": "servo 2: overheating error (bit 2)"})

    bench.peer.alter_state = sick
    assert bench.fault() == "tendons: servo 2: overheating error (bit 2)"
    assert bench.ask(ControlAction.RESET) == "reset"
    assert "the tendon driver reports servo 2" in bench.ask(ControlAction.ARM)


def test_a_silent_servo_driver_is_a_fault(bench: ControllerBench) -> None:
    bench.track()
    bench.peer.alter_state = lambda state: []
    assert bench.fault().startswith("tendons stale: ")


def test_poses_of_another_rig_arm_nothing_and_a_model_without_solution_is_a_fault(tmp_path: Path) -> None:
    with rig(tmp_path, TOO_STRONG) as one:
        controller = one.controller()
        with one.session() as session:
            one.status(session)
            pose = TipPose(seq=1, stamp_ns=0, position=(0.0, 0.0, 0.5), orientation=(1.0, 0.0, 0.0, 0.0))
            session.put(key("another", TIP_POSE), pose.model_dump_json())
            reply = one.ask(session, ControlAction.ARM)
            assert (reply.done, reply.message) == (False, "not armed: no pose of the tip has arrived yet")
            config = parse_config(one.config.read_text(), "test")
            with Peer(config, session) as peer:
                rest: list[TipPose] = []

                def still(pose: TipPose) -> Outgoing:
                    rest.append(pose)
                    x, y, z = rest[0].position
                    yield moved(pose, (x, y + 1e-5 * (len(rest) % 2), z))

                peer.alter = still
                one.until(session, lambda s: s.tip is not None)
                assert one.ask(session, ControlAction.ARM).done
                status = one.until(session, lambda s: s.mode is Mode.FAULT and s.tension == (0.0,) * 4)
                assert status.reason.startswith("model: no solution for ")
                assert not peer.unsafe()
        assert one.end(controller)[0] == 0


TOO_WEAK = """
[limits]
tension_max = 15.0
[reference]
unreachable = "track"
"""
"""The target takes 40 N."""


def test_a_command_that_stands_at_a_limit_is_clamped_and_in_the_end_a_fault(tmp_path: Path) -> None:
    with rig(tmp_path, TOO_WEAK) as one:
        controller, _ = one.controller(), one.start("simulate")
        with one.session() as session:
            one.arm(session)
            status = one.until(session, lambda s: s.mode is Mode.FAULT and s.tension == (0.0,) * 4)
        assert status.reason.startswith("limits: the command stood at one for 1 s: ")
        assert one.end(controller)[0] == 0
    records = load(tmp_path / "run.mcap").records
    assert max(record.command.tension[0] for record in records) == 15.0
    assert sum("tension max" in record.limited for record in records) >= 95  # the others at its rate
