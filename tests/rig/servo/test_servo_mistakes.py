"""A calibration that is wrong, on the rod behind emulated servos: how hard the driver lets them pull, release included.

The controller here is the test, and sees nothing: it commands what a right calibration would bear, then lets go.
"""

import socket
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.state import rod_from_section
from tendond.daemon.runtime.bus import Arrivals, Hub
from tendond.drivers.dynamixel.calibration import Calibration, save_calibration
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.wired.rig import WiredRig, without_servos
from tendond.schemas.config.presets import WIRED, WIRED_SERVO, WIRED_VICON
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import calibration
from tests.rig.tracker import free_port
from tests.sil.rig import rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

PATIENCE_SECONDS = 60.0
PERIOD = 0.01
TENSION_MAX = 20.0
PULL = 15.0
"""[N] of tendon 0, of which the commanded displacements are made."""

RAMP_CYCLES, HOLD_CYCLES = 100, 100
ALLOWED = 1.5 * TENSION_MAX + 15.0
"""[N] servo.tension_margin, and what a stiff tendon gains until the driver has seen it."""


def change(made: Calibration, index: int, **changes: Any) -> Calibration:
    """The calibration with one tendon changed."""
    tendons = list(made.tendons)
    tendons[index] = tendons[index].model_copy(update=changes)
    return made.model_copy(update={"tendons": tuple(tendons)})


def right(made: Calibration) -> Calibration:
    return made


def wrong_sign(made: Calibration) -> Calibration:
    return change(made, 0, sign=-1)


def half_the_radius(made: Calibration) -> Calibration:
    for index in range(4):
        made = change(made, index, spool_radius=0.0075)
    return made


def swapped(made: Calibration) -> Calibration:
    """Tendons 0 and 1 are on each other's servo."""
    return change(change(made, 0, sign=made.tendons[1].sign), 1, sign=made.tendons[0].sign)


@pytest.mark.parametrize("mistake", [right, wrong_sign, half_the_radius, swapped])
def test_whatever_is_wrong_in_the_calibration_no_tendon_pulls_much_harder_than_tension_max(
    tmp_path: Path, mistake: Any
) -> None:
    text = (
        WIRED.replace("tension_max = 60.0", f"tension_max = {TENSION_MAX}")
        .replace("displacement_min = -0.08", "displacement_min = -0.035")
        .replace("displacement_max = 0.08", "displacement_max = 0.035")
        .replace("displacement_rate = 0.08", "displacement_rate = 0.04")
    )
    wiring = f"\n[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n{WIRED_VICON}"
    limits = "displacement_min = -0.035\ndisplacement_max = 0.035\n"
    servo = f'\n[servo]\nport = "{tmp_path}/ttyUSB0"\n{WIRED_SERVO}{limits}'
    ended = threading.Event()
    with rig(tmp_path, text + wiring + servo) as one:
        config = parse_config(one.config.read_text(), "rig.toml")
        assert config.servo is not None
        assert config.vicon is not None
        true = calibration(rig=one.name)
        save_calibration(tmp_path / "calibration.json", mistake(true))
        on_the_rig = true
        if mistake is swapped:
            on_the_rig = true.model_copy(update={"tendons": (true.tendons[1], true.tendons[0], *true.tendons[2:])})
        plant = Plant(without_servos(config), rod_from_section(config.simulator.rod, PERIOD))
        wired = WiredRig(config, config.servo, config.vicon, on_the_rig, plant, ended.is_set)
        thread = threading.Thread(target=wired.run)
        thread.start()
        try:
            with Hub(config) as hub:
                driver = one.start("servo")
                pulls, faults = _drive(hub, rod_from_section(config.rod, PERIOD))
                _, said = one.end(driver)
        finally:
            ended.set()
            thread.join()
            wired.close()
    print(f"{mistake.__name__}: {max(pulls):.1f} N; {faults}")
    assert "Traceback" not in said
    assert max(pulls) < ALLOWED
    assert not any(servo.energised for servo in wired.bus.servos)
    if mistake is right:
        assert "while it is released" not in said
        assert faults == []
        assert max(pulls) > 0.8 * PULL


def _drive(hub: Hub, model: Any) -> tuple[list[float], list[str]]:
    """Wind up, hold, let go: true tensions of all tendons [N], and what the driver said while armed."""
    rest = model.solve_static(np.zeros(4))
    pulled = model.solve_static(np.array([PULL, 0.0, 0.0, 0.0]))
    start, target = model.displacements(rest), model.displacements(pulled, elastic=True)
    seq, seen = 0, Arrivals()
    pulls: list[float] = []
    faults: list[str] = []

    def cycle(displacement: np.ndarray, *, armed: bool) -> None:
        nonlocal seq
        seq += 1
        values = tuple(np.asarray(displacement).tolist())
        hub.publish_command(
            TendonCommand(seq=seq, stamp_ns=0, pose_seq=None, displacement=values, tension=(0.0,) * 4, armed=armed)
        )
        hub.receive(seen)
        if (truth := seen.decoded_truth()) is not None:
            pulls.extend(truth.tension)
        if armed and seen.tendon_state is not None and seen.tendon_state.fault:
            faults[:] = [seen.tendon_state.fault]
        time.sleep(PERIOD)

    deadline = time.monotonic() + PATIENCE_SECONDS
    while seen.tendon_state is None or seen.tendon_state.fault:
        assert time.monotonic() < deadline, seen.tendon_state
        cycle(start, armed=False)
    for number in range(RAMP_CYCLES + HOLD_CYCLES):
        share = min(1.0, number / RAMP_CYCLES)
        cycle(start + share * (target - start), armed=True)
    for _ in range(150):
        cycle(start, armed=False)
    return pulls, faults
