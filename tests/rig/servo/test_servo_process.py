"""`tendond servo` as a process that is killed: where its tendons were is on disk, and the tools use it."""

import signal
import time
from pathlib import Path

import pytest

from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.places import read_places
from tendond.drivers.dynamixel.serial import table
from tendond.schemas.config.presets import WIRED, WIRED_SERVO
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import RADIUS, calibration, emulated, hang_springs
from tests.sil.rig import rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

PATIENCE_SECONDS = 40.0
PULLED = 0.02


def test_home_releases_pulled_tendons_by_the_places_that_a_killed_driver_left(tmp_path: Path) -> None:
    """The first spool was turned by hand with the power on: its servo counts three turns more than the calibration."""
    with (
        emulated(tmp_path) as servos,
        rig(tmp_path, f'{WIRED}\n[servo]\nport = "{tmp_path}/ttyUSB0"\n{WIRED_SERVO}') as one,
    ):
        made = calibration(rig=one.name)
        save_calibration(tmp_path / "calibration.json", made)
        hang_springs(servos.servos, made)
        servos.apply(lambda: setattr(servos.servos[0], "_turns", 3))
        config = parse_config(one.config.read_text(), "rig.toml")
        with Hub(config) as hub:
            driver = one.start("servo")
            seq, arrivals = 0, Arrivals()

            def command(place: float, *, armed: bool) -> None:
                nonlocal seq
                seq += 1
                displacement = (place, 0.0, 0.0, 0.0)
                hub.publish_command(
                    TendonCommand(
                        seq=seq, stamp_ns=0, pose_seq=None, displacement=displacement, tension=(0.0,) * 4, armed=armed
                    )
                )
                hub.receive(arrivals)
                time.sleep(0.01)

            deadline = time.monotonic() + PATIENCE_SECONDS
            while arrivals.tendon_state is None or arrivals.tendon_state.fault:
                assert time.monotonic() < deadline, arrivals.tendon_state
                command(0.0, armed=False)
            while abs(arrivals.tendon_state.displacement[0] - PULLED) > 1e-3:
                assert time.monotonic() < deadline, arrivals.tendon_state
                command(PULLED, armed=True)
                assert arrivals.tendon_state is not None
            for _ in range(30):
                command(PULLED, armed=True)
            driver.send_signal(signal.SIGKILL)
            driver.wait()
        assert read_places(tmp_path / "calibration-places.json", made)[1] == pytest.approx(PULLED, abs=3e-3)
        assert servos.servos[0].energised
        home = one.start("servo", "home", "--yes")
        said, complaint = home.communicate(timeout=PATIENCE_SECONDS)
        assert home.returncode == 0, complaint
        assert "tendon 0 (servo 1): stands 20." in said or "tendon 0 (servo 1): stands 19." in said
        assert (servos.servos[0].position - 2048) * table.TICK * RADIUS == pytest.approx(0.0, abs=1.5e-3)
        assert not any(servo.energised for servo in servos.servos)
