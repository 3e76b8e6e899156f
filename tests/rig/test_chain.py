"""The whole chain: rod <- emulated servos <- pseudo-terminal <- SDK <- `tendond servo` <- Zenoh <- `tendond run` <-
Zenoh <- `tendond rig vicon` <- UDP <- simulated Tracker <- rod. Drivers and controller are processes; the rig is a
thread here, so that faults can be caused on it. The tests share one rig; each leaves it idle.
"""

import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
import zenoh

from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.simulator.faults import Faults, request_fault
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.wired.faults import cause
from tendond.drivers.wired.rig import WiredError, WiredRig
from tendond.model.rods.selection import rod_from_section
from tendond.offline.logs.log import load
from tendond.schemas.config.rig import check_config
from tendond.schemas.faults import FAULTS, Fault, FaultRequest
from tendond.schemas.keys import TENDON_STATE, TIP_POSE
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.rig.chain import PATIENCE_SECONDS, Chain
from tests.rig.servos import calibration, emulated
from tests.sil.rig import Rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

LANDING = np.array([0.340, 0.0, 0.0475])


@pytest.fixture(scope="module")
def chain(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chain]:
    one = Chain(tmp_path_factory.mktemp("chain"))
    try:
        one.controller()
        yield one
    finally:
        one.close()


@pytest.fixture
def session(chain: Chain) -> Iterator[zenoh.Session]:
    with chain.session() as one:
        yield one


def test_the_tip_lands_where_it_should_and_stop_leaves_every_servo_off(chain: Chain, session: zenoh.Session) -> None:
    chain.track(session, 0.05)
    status = chain.until(session, lambda s: np.allclose(s.tip or (0, 0, 0), LANDING, atol=1e-3))
    assert status.displacement[0] == pytest.approx(0.0598, abs=1e-3)
    assert chain.torques == [True] * 4
    assert chain.wired._tendons[0].tension == pytest.approx(43.0, abs=2.0)
    loads = [servo.value(table.PRESENT_LOAD) for servo in chain.wired.bus.servos]
    assert loads[0] == pytest.approx(43.0 * 0.015 / 1.4 * 1000.0, rel=0.1)
    assert chain.ask(session, ControlAction.STOP).done
    chain.until(session, lambda s: s.mode is Mode.IDLE)
    chain.wait_for_slack_and_off()


def test_a_hardware_error_of_one_servo_is_named_by_the_controller_and_all_end_slack(
    chain: Chain, session: zenoh.Session
) -> None:
    chain.track(session, 0.2)
    inject = ["rig", "inject", "overload", "--servo", "2"]
    assert chain.start(*inject).wait(PATIENCE_SECONDS) == 0
    status = chain.until(session, lambda s: s.mode is Mode.FAULT)
    assert "servo 2: Overload Error (bit 5)" in status.reason
    chain.wait_for_slack_and_off()
    chain.until(session, lambda s: s.tension == (0.0,) * 4)
    assert not chain.ask(session, ControlAction.ARM).done
    refused = chain.reset_servos()
    assert not refused.done
    assert "Overload Error" in refused.message
    assert request_fault(chain.settings, FaultRequest(fault=Fault.CLEAR, servo=2), 30.0).done
    assert chain.reset_servos().done
    chain.until(session, lambda s: chain.ask(session, ControlAction.RESET).done or s.mode is Mode.IDLE)
    chain.track(session, 0.05)
    assert chain.ask(session, ControlAction.STOP).done
    chain.until(session, lambda s: s.mode is Mode.IDLE)
    chain.wait_for_slack_and_off()


def test_a_tracker_that_falls_silent_releases_the_tendons(chain: Chain, session: zenoh.Session) -> None:
    chain.track(session, 0.2)
    chain.drivers["vicon"].send_signal(signal.SIGSTOP)
    try:
        status = chain.until(session, lambda s: s.mode is Mode.FAULT)
        assert "pose stale" in status.reason
        chain.until(session, lambda s: s.tension == (0.0,) * 4)
        chain.wait_for_slack_and_off()
    finally:
        chain.drivers["vicon"].send_signal(signal.SIGCONT)
    chain.until(session, lambda s: chain.ask(session, ControlAction.RESET).done or s.mode is Mode.IDLE)


def test_a_simulator_left_running_beside_the_real_drivers_is_named_refused_and_a_fault(
    chain: Chain, session: zenoh.Session
) -> None:
    chain.until(session, lambda s: s.tip is not None)
    topics = (TIP_POSE, TENDON_STATE)
    ghost = chain.start("simulate")
    status = chain.until(session, lambda s: all(len(s.sources.get(topic, ())) == 2 for topic in topics))
    for topic, driver in zip(topics, ("vicon-", "servo-"), strict=True):
        assert {name.startswith(driver) for name in status.sources[topic]} == {True, False}, status.sources
        assert any(name.startswith("simulator-") for name in status.sources[topic]), status.sources
    reply = chain.ask(session, ControlAction.ARM)
    assert not reply.done
    assert "two sources of t" in reply.message
    assert "simulator-" in reply.message
    assert not any(chain.torques)
    chain.end(ghost)
    chain.until(session, lambda s: all(len(s.sources[topic]) == 1 for topic in topics))
    chain.track(session, 0.05)
    ghost = chain.start("simulate")
    status = chain.until(session, lambda s: s.mode is Mode.FAULT)
    assert "two sources of t" in status.reason
    assert "simulator-" in status.reason
    chain.end(ghost)
    chain.wait_for_slack_and_off()
    chain.until(session, lambda s: chain.ask(session, ControlAction.RESET).done or s.mode is Mode.IDLE)


def test_after_a_killed_controller_servos_stop_by_themselves_and_the_next_one_gets_the_reason(chain: Chain) -> None:
    controller = chain.started["run"]
    with chain.session() as session:
        chain.track(session, 0.12)
    controller.kill()
    controller.wait()
    deadline = time.monotonic() + PATIENCE_SECONDS
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in chain.wired.bus.servos):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert chain.torques == [True] * 4
    assert chain.wired._tendons[0].displacement > 0.01
    chain.start("run", "--log", str(chain.folder / "second.mcap"))
    with chain.session() as session:
        chain.until(session, lambda s: s.tip is not None)
        deadline = time.monotonic() + PATIENCE_SECONDS
        while "no command for" not in (reply := chain.ask(session, ControlAction.ARM)).message:
            assert not reply.done
            assert time.monotonic() < deadline, reply.message
        assert chain.reset_servos().done
        chain.wait_for_slack_and_off()
        chain.track(session, 0.02)


def test_the_servo_driver_releases_and_switches_off_at_a_signal(chain: Chain) -> None:
    """The chain is still tracking from the test before; the controller learns it from the silence."""
    driver = chain.drivers["servo"]
    code, said = chain.end(driver)
    assert code == 0, said
    assert "stopped; the tendons are released, the torque is off" in said
    assert "Traceback" not in said
    assert not any(chain.torques)


def test_the_log_of_a_chain_holds_the_truth_beside_what_was_measured(chain: Chain) -> None:
    log = load(chain.folder / "run.mcap")
    states = [record.inputs.tendon_state for record in log.records if record.inputs.tendon_state is not None]
    # 59.8 mm at rest, and a little more while it moves.
    assert max(state.displacement[0] for state in states) == pytest.approx(0.0598, abs=3e-3)
    assert any("servo 2: Overload Error" in state.fault for state in states)
    assert log.calibration == calibration(rig=chain.name)


def test_the_controller_refuses_a_calibration_of_another_rig(tmp_path: Path) -> None:
    limits = "[limits]\ndisplacement_min = -0.08\ndisplacement_max = 0.08\ndisplacement_rate = 0.08\n"
    one = Rig(tmp_path, f"[servo]\n{limits}")
    save_calibration(tmp_path / "calibration.json", calibration(rig="yours"))
    process = one.controller()
    _, said = process.communicate(timeout=PATIENCE_SECONDS)
    assert process.returncode == 2
    assert said == f"tendond: {tmp_path}/calibration.json: is of rig 'yours', this is 'sil': calibrate this one\n"
    assert not (tmp_path / "run.mcap").exists()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"simulator": {"drive": "tension"}}, "simulator.drive = 'tension'"),
        ({"vicon": {"base": ""}}, "vicon.base is empty"),
        ({"vicon": {"euler_order": "ZYX"}}, "vicon.euler_order = 'ZYX'"),
        ({"servo": {"port": "/dev/ttyUSB0"}}, "may be a real port"),
        ({"servo": {"port": "/nowhere/at/all"}}, "there is no folder /nowhere/at"),
    ],
)
def test_wires_are_not_laid_where_they_would_replace_or_miss_something(
    change: dict[str, dict[str, object]], message: str
) -> None:
    data: dict[str, dict[str, object]] = {
        "simulator": {"drive": "displacement"},
        "vicon": {},
        "servo": {},
        "limits": {"displacement_min": -0.08, "displacement_max": 0.08, "displacement_rate": 0.08},
    }
    config = check_config({name: {**section, **change.get(name, {})} for name, section in data.items()}, "test")
    assert config.servo is not None
    assert config.vicon is not None
    plant = Plant(config, rod_from_section(config.simulator.rod, 0.01))
    with pytest.raises(WiredError, match=message):
        WiredRig(config, config.servo, config.vicon, calibration(), plant, lambda: True)


def test_every_fault_of_the_wires_can_be_caused_and_cleared(tmp_path: Path) -> None:
    with emulated(tmp_path) as bus:
        second, others = bus.servos[1], Faults(4)
        observed: dict[Fault, Callable[[], bool]] = {
            Fault.SILENT: lambda: second.silent,
            Fault.STUCK: lambda: second.stuck,
            Fault.OVERLOAD: lambda: second.alert,
            Fault.HOT: lambda: second.temperature > 72.0,
            Fault.CRC: lambda: bus.corrupt > 0,
            Fault.LOSS: lambda: bus.loss == 0.2,
            Fault.LATE: lambda: bus.late == 0.016,
            Fault.BROWNOUT: lambda: second.voltage < 5.0,
            Fault.TURNED: lambda: second.value(table.PRESENT_POSITION) > 3 * table.TICKS_PER_TURN,
            Fault.UNPLUG: lambda: not (tmp_path / "ttyUSB0").exists(),
            Fault.PLUG: lambda: (tmp_path / "ttyUSB0").exists(),
            Fault.REBOOT: lambda: not second.energised,
            Fault.CUT: lambda: others.cut == [1],
        }
        assert {*observed, Fault.CLEAR} >= {fault for fault, kind in FAULTS.items() if kind.wires or kind.servo}
        for fault, happened in observed.items():
            second.write(table.TORQUE_ENABLE.address, b"\x01")
            assert cause(bus, others, FaultRequest(fault=fault, servo=2 if FAULTS[fault].servo else None)).done
            assert happened(), fault
            assert cause(bus, others, FaultRequest(fault=Fault.CLEAR, servo=2)).done
            assert (second.silent, second.stuck, second.alert, second.temperature) == (False, False, False, 30.0)
        assert cause(bus, others, FaultRequest(fault=Fault.CLEAR)).done
        assert (bus.loss, bus.late) == (0.0, 0.0)
        refused = cause(bus, others, FaultRequest(fault=Fault.HOT, servo=9))
        assert not refused.done
        assert "the servos are 1, 2, 3, 4" in refused.message


def test_a_missing_section_of_a_driver_is_named(tmp_path: Path) -> None:
    one = Rig(tmp_path)
    for command, words in (("vicon", ("rig", "vicon")), ("servo", ("servo",))):
        process = one.start(*words)
        _, said = process.communicate(timeout=60)
        assert process.returncode == 2
        assert said == f"tendond: {one.config}: has no [{command}] section: add one, it may be empty\n"
    assert isinstance(process, subprocess.Popen)
