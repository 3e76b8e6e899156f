"""Four tendons at once, each pretensioned against the one opposite, through the driver, the wires and emulated servos.

The controller here is the test: it knows which displacements let the tip go round in a circle with every tendon taut.
"""

import math
import socket
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.state import rod_from_section
from tendond.daemon.runtime.bus import Arrivals, Hub
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.driver.guard import limited
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.wired.rig import WiredRig, without_servos
from tendond.schemas.config.presets import WIRED, WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import SimulatorTruth, TendonCommand
from tests.rig.servos import calibration
from tests.rig.tracker import free_port
from tests.sil.rig import rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

PATIENCE_SECONDS = 60.0
PERIOD = 0.01
TENSION_MIN, TENSION_MAX = 2.0, 8.0
"""[N] Of each tendon on the circle."""

TURN = 250
"""Cycles."""


def circle(cycle: int) -> np.ndarray:
    """Tensions [N], shape (4,), each tendon pulling when the circle passes its side; the first turn winds up."""
    size = min(1.0, cycle / TURN)
    angle = 2.0 * math.pi * cycle / TURN
    sides = np.array([math.cos(angle - 0.5 * math.pi * tendon) for tendon in range(4)])
    return np.asarray(size * (TENSION_MIN + (TENSION_MAX - TENSION_MIN) * np.maximum(0.0, sides)))


def test_all_four_tendons_wind_at_once_and_stay_taut_while_the_tip_goes_round(tmp_path: Path) -> None:
    wiring = f"\n[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n{WIRED_VICON}"
    servo = f'\n[servo]\nport = "{tmp_path}/ttyUSB0"\n{WIRED_SERVO}'
    ended = threading.Event()
    with rig(tmp_path, WIRED + wiring + servo) as one:
        config = parse_config(one.config.read_text(), "rig.toml")
        assert config.servo is not None
        assert config.vicon is not None
        calibrated = calibration(rig=one.name)
        save_calibration(tmp_path / "calibration.json", calibrated)
        plant = Plant(without_servos(config), rod_from_section(config.simulator.rod, PERIOD))
        wired = WiredRig(config, config.servo, config.vicon, calibrated, plant, ended.is_set)
        thread = threading.Thread(target=wired.run)
        thread.start()
        try:
            with Hub(config) as hub:
                driver = one.start("servo")
                travel, taut, tip = _drive(hub, config)
                code, said = one.end(driver)
        finally:
            ended.set()
            thread.join()
            wired.close()
    assert code == 0, said
    assert "fault: servo" not in said
    assert "fault: tendon" not in said
    assert min(travel) > 0.01  # every one of them winds up and lets out
    assert min(taut) > 0.25 * TENSION_MIN  # and none of them falls slack on the way
    assert np.linalg.norm(tip) < 2e-3  # in the end the tip is where the model has it
    assert not any(servo.energised for servo in wired.bus.servos)


def _drive(hub: Hub, config: RigConfig) -> tuple[list[float], list[float], np.ndarray]:
    """Command two turns and a rest: each tendon's travel [m], its least tension on the second [N], the tip's error."""
    model = rod_from_section(config.rod, PERIOD)
    state = model.solve_static(np.zeros(4))
    seq, arrivals = 0, Arrivals()
    truths: list[SimulatorTruth] = []

    def cycle(displacement: np.ndarray, *, armed: bool) -> None:
        nonlocal seq
        seq += 1
        values = tuple(displacement.tolist())
        hub.publish_command(
            TendonCommand(seq=seq, stamp_ns=0, pose_seq=None, displacement=values, tension=(0.0,) * 4, armed=armed)
        )
        hub.receive(arrivals)
        if (truth := arrivals.decoded_truth()) is not None:
            truths.append(truth)
        time.sleep(PERIOD)

    rest = model.displacements(state)
    deadline = time.monotonic() + PATIENCE_SECONDS
    while arrivals.tendon_state is None or arrivals.tendon_state.fault:
        assert time.monotonic() < deadline, arrivals.tendon_state
        cycle(rest, armed=False)
    turned = 0
    places = []
    for number in range(2 * TURN):
        if number == TURN:
            turned = len(truths)
        state = model.step(state, circle(number))
        cycle(model.displacements(state, elastic=True), armed=True)
        assert arrivals.tendon_state is not None
        assert arrivals.tendon_state.fault == ""
        places.append(arrivals.tendon_state.displacement)
    tensions = np.array([truth.tension for truth in truths[turned:]])
    last = model.displacements(state, elastic=True)
    still = model.solve_static(displacements=last)
    target = model.tip(still).position
    deadline = time.monotonic() + PATIENCE_SECONDS
    while np.linalg.norm(np.array(truths[-1].position) - target) > 1e-3 and time.monotonic() < deadline:
        cycle(last, armed=True)
    return (
        np.ptp(np.array(places), axis=0).tolist(),
        tensions.min(axis=0).tolist(),
        np.array(truths[-1].position) - target,
    )


def test_tendons_that_are_too_fast_are_slowed_down_together_and_keep_their_proportion() -> None:
    section = ServoSection(period=PERIOD, displacement_rate=0.05)
    wanted, last = (0.010, -0.004, -0.010, 0.004), (0.0, 0.0, 0.0, 0.0)
    goals = limited(section, wanted, last, PERIOD)
    assert goals == pytest.approx([0.05 * one for one in wanted])
    assert limited(section, (2e-4, 0.0, 0.0, 0.0), last, PERIOD) == (2e-4, 0.0, 0.0, 0.0)
    bounded = limited(section, (1e300, -1e300, 0.0, 0.0), last, PERIOD)
    assert bounded == pytest.approx((0.0005, -0.0005, 0.0, 0.0))
