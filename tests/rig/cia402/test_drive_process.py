"""`tendond servo` as a process on a serial CAN adapter, a real pseudo-terminal: it is killed, and ended in order."""

import signal
import time
from pathlib import Path

import pytest

from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.drivers.cia402.emulated_bus import EmulatedDrives
from tendond.drivers.cia402.emulator import EmulatedDrive
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config.presets import WIRED
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import TendonCommand
from tests.rig.cia402.bench import COUNTS, RATED, drive_calibration, emulated_drives
from tests.rig.cia402.serial_adapter import SerialAdapter
from tests.sil.rig import rig

pytestmark = [pytest.mark.rig, pytest.mark.sil]

PATIENCE_SECONDS = 40.0
PULLED = 0.02


def places(drives: list[EmulatedDrive]) -> list[float]:
    made = drive_calibration()
    return [Spool(t).displacement(round(d.position)) for t, d in zip(made.tendons, drives, strict=True)]


def test_killed_the_driver_is_missed_by_the_drives_and_ended_it_releases_the_tendons(tmp_path: Path) -> None:
    made = drive_calibration("sil")
    drives = emulated_drives(made)
    with SerialAdapter() as adapter:
        text = f"""{WIRED}
[servo]
period = 0.05
silent_reads = 20
following_time = 2.0
command_timeout = 1.0
[drives]
interface = "slcan"
channel = "{adapter.port}"
counts_per_turn = {COUNTS}
rated_torque = {RATED}
heartbeat = 2.0
reply_timeout = 0.045
"""
        with EmulatedDrives(adapter, drives) as emulated, rig(tmp_path, text) as one:
            save_calibration(tmp_path / "calibration.json", made)
            config = parse_config(one.config.read_text(), "rig.toml")
            with Hub(config) as hub:
                seq, arrivals = 0, Arrivals()

                def command(place: float, *, armed: bool) -> None:
                    nonlocal seq
                    seq += 1
                    displacement = (place, 0.0, 0.0, 0.0)
                    hub.publish_command(
                        TendonCommand(
                            seq=seq,
                            stamp_ns=0,
                            pose_seq=None,
                            displacement=displacement,
                            tension=(0.0,) * 4,
                            armed=armed,
                        )
                    )
                    hub.receive(arrivals)
                    time.sleep(0.01)

                def pull() -> None:
                    deadline = time.monotonic() + PATIENCE_SECONDS
                    arrivals.tendon_state = None
                    while arrivals.tendon_state is None or arrivals.tendon_state.fault:
                        assert driver.poll() is None, driver.communicate()
                        assert time.monotonic() < deadline, arrivals.tendon_state
                        command(0.0, armed=False)
                    while abs(arrivals.tendon_state.displacement[0] - PULLED) > 1e-3:
                        assert time.monotonic() < deadline, arrivals.tendon_state
                        command(PULLED, armed=True)
                        assert arrivals.tendon_state is not None

                driver = one.start("servo")
                pull()
                assert places(drives)[0] == pytest.approx(PULLED, abs=1e-3)
                assert all(drive.powered for drive in drives)
                driver.send_signal(signal.SIGKILL)
                driver.wait()
                deadline = time.monotonic() + PATIENCE_SECONDS
                while any(drive.powered for drive in drives):
                    assert time.monotonic() < deadline
                    time.sleep(0.02)

                emulated.apply(lambda: setattr(drives[0], "position", drives[0].rest))
                driver = one.start("servo")
                pull()
                driver.send_signal(signal.SIGTERM)
                _, said = driver.communicate(timeout=PATIENCE_SECONDS)
                assert driver.returncode == 0, said
                assert "4 drives on slcan" in said
                assert "stopped; the tendons are released, the torque is off" in said
                assert not any(drive.powered for drive in drives)
                assert places(drives) == pytest.approx((0.0,) * 4, abs=2e-3)
