"""The simulator as a process: a profile by name, faults at run time by `tendond rig inject`, the truth in the log."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import zenoh

from tendond.drivers.simulator.faults import request_fault
from tendond.offline.logs.log import load
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import parse_config
from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.sil.rig import PATIENCE_SECONDS, Rig, rig

pytestmark = pytest.mark.sil

PATIENT = "[faults]\noverrun_time = 10.0\npose_timeout = 1.0\ntendon_timeout = 1.2\n"
"""The machine may stand still for a while; the faults that are injected last longer."""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Rig, zenoh.Session]]:
    """The profile 'rig' with controller and simulator as processes; each test leaves it idle."""
    with rig(tmp_path_factory.mktemp("simulator"), PATIENT + RIG.replace("duration = 2.0", "duration = 1.5")) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            yield one, session


def inject(one: Rig, *arguments: str) -> str:
    process = one.start("rig", "inject", *arguments)
    said, complained = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 0, complained
    return said


def leave(one: Rig, session: zenoh.Session) -> None:
    """Make the rig slack, repaired and idle."""
    assert request_fault(parse_config(one.config.read_text(), "rig.toml"), FaultRequest(fault=Fault.CLEAR)).done
    one.ask(session, ControlAction.STOP)
    one.until(session, lambda s: one.ask(session, ControlAction.RESET).done or s.mode is Mode.IDLE)


def test_the_rig_profile_is_tracked_by_real_processes(shared: tuple[Rig, zenoh.Session]) -> None:
    one, session = shared
    one.arm(session)
    status = one.until(session, lambda s: abs((s.tip or (0,))[0] - 0.34) < 2e-3 and (s.tip or (0, 0, 1))[2] < 0.06)
    assert status.mode is Mode.TRACKING
    leave(one, session)


@pytest.mark.parametrize(
    ("arguments", "reasons"),
    [
        (("occlusion", "--seconds", "2"), ("occluded",)),
        (("dropout", "--seconds", "2"), ("pose stale", "bad poses")),
        (("silence", "--seconds", "2"), ("pose stale", "bad poses")),
        (("teleport", "--size", "1", "--seconds", "2", "--direction", "y"), ("pose stale", "bad poses")),
        (("overload", "--servo", "3"), ("servo 3: Overload Error (bit 5)",)),
    ],
)
def test_a_fault_that_the_controller_must_not_tolerate_is_named_and_releases_the_tendons(
    shared: tuple[Rig, zenoh.Session], arguments: tuple[str, ...], reasons: tuple[str, ...]
) -> None:
    one, session = shared
    one.arm(session)
    inject(one, *arguments)
    status = one.until(session, lambda s: s.mode is Mode.FAULT)
    assert any(reason in status.reason for reason in reasons), status.reason
    one.until(session, lambda s: s.tension == (0.0,) * 4)
    leave(one, session)


def test_what_cannot_be_caused_is_refused_in_one_line(shared: tuple[Rig, zenoh.Session]) -> None:
    one, _ = shared
    refused = [
        (("crc",), 1, "crc needs wires"),
        (("stuck", "--servo", "7"), 1, "there is no servo 7; the servos are 1 to 4"),
        (("stuck",), 2, "stuck needs a servo"),
        (("occlusion", "--size", "1"), 2, "occlusion takes no size"),
        (("noise", "--size", "9"), 2, "noise takes at most 0.05 m"),
        (("earthquake",), 2, "'earthquake' is not a fault"),
    ]
    processes = [one.start("rig", "inject", *arguments) for arguments, _, _ in refused]
    for process, (_, code, message) in zip(processes, refused, strict=True):
        _, said = process.communicate(timeout=PATIENCE_SECONDS)
        assert process.returncode == code, said
        assert message in said
        assert said.count("\n") == 1


def test_a_weight_and_an_impact_are_tolerated_and_the_log_holds_the_truth(shared: tuple[Rig, zenoh.Session]) -> None:
    """Weights and pushes are in the log as forces on the tip; poses differ from the truth by noise and age."""
    one, session = shared
    one.arm(session)
    assert "weight of 0.03 kg until it is cleared" in inject(one, "weight", "--size", "0.03")
    inject(one, "impact", "--size", "1", "--direction", "-z")
    status = one.until(session, lambda s: abs((s.tip or (0,))[0] - 0.34) < 5e-3 and (s.tip or (0, 0, 1))[2] < 0.06)
    assert status.mode is Mode.TRACKING
    inject(one, "clear")
    leave(one, session)
    one.until(session, lambda s: s.mode is Mode.IDLE)
    for process in reversed(one.processes):
        if process.poll() is None:
            assert one.end(process)[0] == 0
    log = load(one.folder / "run.mcap")
    assert len(log.truth) > 0.5 * len(log.records)
    forces = np.array([truth.tip_force for truth in log.truth])
    assert forces[:, 0].min() == pytest.approx(-0.03 * 9.81)
    assert forces[:, 2].min() == pytest.approx(-1.0)
    assert max(truth.position[0] for truth in log.truth) > 0.3


def test_a_file_and_a_profile_at_once_and_an_unknown_profile_are_refused(tmp_path: Path) -> None:
    with rig(tmp_path) as one:
        processes = [
            one.start(command, "--profile", profile) for command in ("run", "simulate") for profile in ("rig", "nice")
        ]
        for process in processes:
            _, said = process.communicate(timeout=PATIENCE_SECONDS)
            assert (process.returncode, "give one of them" in said, said.count("\n")) == (2, True, 1), said
