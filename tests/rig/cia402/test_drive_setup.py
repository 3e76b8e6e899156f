"""What the driver sets in a drive, which drives it refuses, and what a configuration may ask of them."""

from collections.abc import Callable
from pathlib import Path

import can
import pytest

from tendond.cli.servo.servo import reboot_servos, scan_servos, set_up_servo
from tendond.cli.servo.tendons import home_servos
from tendond.drivers.cia402.emulated_bus import EmulatedDrives
from tendond.drivers.cia402.emulator import EmulatedDrive
from tendond.drivers.cia402.process import drive_driver
from tendond.drivers.cia402.states import DriveState, state_of, towards_enabled
from tendond.drivers.dynamixel.serial.bus import PortLostError, ServoError
from tendond.schemas.config.drives import DrivesSection
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.config.servo import ServoSection
from tests.rig.cia402.bench import COUNTS, RATED, drive_bench, drive_calibration, emulated_drives
from tests.rig.servos import RADIUS

pytestmark = pytest.mark.rig


def test_a_drive_is_its_own_watchdog_and_bounds_its_torque() -> None:
    """Objects and values by CiA 301 and CiA 402-2, typed here and not taken from the driver."""
    with drive_bench(heartbeat=0.12, current_max=1.5) as bench:
        drive, load = bench.each[0], bench.servo.tension_margin * 20.0 * RADIUS / RATED
        assert drive.value(0x1016, 1) == 127 << 16 | 120
        assert (drive.value(0x6007), drive.value(0x605A), drive.value(0x605E)) == (3, 2, 2)
        assert drive.value(0x6072) == int(1000 * (load + 0.1))
        assert drive.value(0x6073) == 1500
        assert drive.value(0x6065) == pytest.approx(0.01 / (2 * 3.14159265 * RADIUS) * COUNTS, rel=1e-3)
        assert drive.value(0x6066) == 300
        assert drive.value(0x6060) == 8
        assert drive.value(0x60C2, 1) * 10.0 ** drive.value(0x60C2, 2) == pytest.approx(bench.servo.period)
        assert not drive.powered


def refused(change: Callable[[EmulatedDrive], None], counts: int = COUNTS) -> str:
    """Return what the driver says to a bus whose second drive is changed."""
    made, channel = drive_calibration(), f"refused {counts} {change.__name__}"
    keys = {"interface": "virtual", "channel": channel, "counts_per_turn": counts, "rated_torque": RATED}
    drives = emulated_drives(made)
    change(drives[1])
    with (
        EmulatedDrives(can.Bus(interface="virtual", channel=channel, ignore_config=True), drives, 0.01),
        pytest.raises(ServoError) as error,
    ):
        drive_driver(ServoSection(), DrivesSection.model_validate(keys), made, {}, 20.0)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_a_drive_that_cannot_be_used_is_refused_in_one_line() -> None:
    def silent(drive: EmulatedDrive) -> None:
        drive.silent = True

    def no_drive(drive: EmulatedDrive) -> None:
        drive.put(0x1000, 0, 0x191)

    def no_mode(drive: EmulatedDrive) -> None:
        drive.put(0x6502, 0, 0x1)

    def no_watchdog(drive: EmulatedDrive) -> None:
        drive.remove(0x6007)

    def holding(drive: EmulatedDrive) -> None:
        drive.state = 0x07

    def none(drive: EmulatedDrive) -> None:
        pass

    assert "no reply from servo 2: is it powered" in refused(silent)
    assert "servo 2: has device profile 401, not 402" in refused(no_drive)
    assert "servo 2: does not have the cyclic synchronous position mode" in refused(no_mode)
    assert "servo 2: refuses 3 for Abort connection option code (0x6007)" in refused(no_watchdog)
    assert "servo 2: still holds its tendon" in refused(holding)
    assert "ticks_per_turn = 65536, drives.counts_per_turn is 4096" in refused(none, counts=4096)


def test_an_object_that_is_not_needed_may_be_absent() -> None:
    made = drive_calibration()
    drives = emulated_drives(made)
    for drive in drives:
        for index, sub in ((0x60C2, 1), (0x60C2, 2), (0x6066, 0), (0x605E, 0)):
            if index != 0x6066:  # the emulator's own following error needs it
                drive.remove(index, sub)
    keys = {"interface": "virtual", "channel": "sparse", "counts_per_turn": COUNTS, "rated_torque": RATED}
    with EmulatedDrives(can.Bus(interface="virtual", channel="sparse", ignore_config=True), drives, 0.01):
        driver = drive_driver(ServoSection(), DrivesSection.model_validate(keys), made, {}, 20.0)
        assert driver.report == ""
        driver.session.bus.close()


def test_an_adapter_that_is_not_there_is_one_line() -> None:
    keys = {"interface": "slcan", "channel": "/dev/none", "counts_per_turn": COUNTS, "rated_torque": RATED}
    with pytest.raises(PortLostError, match=r"^slcan /dev/none: cannot be opened: .*drives.interface") as error:
        drive_driver(ServoSection(), DrivesSection.model_validate(keys), drive_calibration(), {}, 20.0)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("statusword", "state", "controlword"),
    [
        (0x0000, DriveState.NOT_READY, 0x00),
        (0x1250, DriveState.DISABLED, 0x06),
        (0x0231, DriveState.READY, 0x07),
        (0x0233, DriveState.SWITCHED_ON, 0x0F),
        (0x1237, DriveState.ENABLED, 0x0F),
        (0x0217, DriveState.QUICK_STOP, 0x00),
        (0x021F, DriveState.REACTING, 0x00),
        (0x0218, DriveState.FAULT, 0x00),
    ],
)
def test_states_are_those_of_the_standard_with_any_other_bits(
    statusword: int, state: DriveState, controlword: int
) -> None:
    assert state_of(statusword) is state
    assert towards_enabled(state) == controlword


DRIVES = "[drives]\ncounts_per_turn = 65536\nrated_torque = 2.0\n"


@pytest.mark.parametrize(
    ("text", "objection"),
    [
        (DRIVES, r"\[drives\] needs \[servo\]"),
        (f"[servo]\n{DRIVES}nodes = [1, 2, 3]\n", "drives.nodes has 3 drives, but the rod has 4 tendons"),
        (f"[servo]\n{DRIVES}nodes = [1, 2, 2, 3]\n", "two tendons have the same drive"),
        (f"[servo]\n{DRIVES}host_node = 4\n", "drives.host_node = 4 is the node id of a drive"),
        (f"[servo]\n{DRIVES}heartbeat = 0.02\n", "must be at least three times servo.period"),
        (f"[servo]\n{DRIVES}reply_timeout = 0.01\n", "must be below servo.period"),
        (f"[servo]\n{DRIVES}[limits]\ntension_max = 100.0\n", r"on a spool of 0.015 m make 93\.3 N"),
        (f"[servo]\n{DRIVES}[limits]\ndisplacement_max = 0.09\n", r"are beyond those of \[servo\], -0\.08 to 0\.08 m"),
    ],
)
def test_what_drives_cannot_do_is_refused_with_the_configuration(text: str, objection: str) -> None:
    with pytest.raises(ConfigError, match=objection):
        parse_config(text, "rig.toml")
    parse_config(f"[servo]\n{DRIVES}[limits]\ntension_max = 20.0\n", "rig.toml")


def test_the_tools_for_dynamixel_servos_refuse_drives_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(f"[servo]\n{DRIVES}")
    uses: tuple[Callable[[], object], ...] = (
        lambda: home_servos(file, True, lambda question: "yes"),
        lambda: scan_servos(file, None, 252),
        lambda: set_up_servo(file, 1, None, None, True, lambda question: "yes"),
        lambda: reboot_servos(file, [1], True, lambda question: "yes"),
    )
    for use in uses:
        with pytest.raises(ConfigError, match=r"^this command is for Dynamixel servos") as error:
            use()
        assert "\n" not in str(error.value)
