"""The turn of a servo follows from its last known place, kept on disk, and from nothing else."""

import math
import time
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.places import PlaceKeeper, places_file, read_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.turns import locate
from tendond.schemas.config.servo import ServoSection
from tests.rig.bench import DriverBench, section
from tests.rig.servos import RADIUS, calibration, emulated

pytestmark = pytest.mark.rig

TENDON = TendonCalibration(servo=1, zero=2048, sign=1, spool_radius=RADIUS)


def ticks(displacement: float) -> int:
    return 2048 + round(displacement / RADIUS / table.TICK)


@pytest.mark.parametrize("turns", [-3, -1, 0, 1, 7])
@pytest.mark.parametrize("last", [-0.08, -0.047, -0.01, 0.0, 0.02, 0.047, 0.0593, 0.08])
@pytest.mark.parametrize("gone", [0.0, 0.3, 0.7, 1.0])
def test_the_place_of_a_tendon_that_moved_without_torque_is_found_or_reported_as_uncertain(
    last: float, turns: int, gone: float
) -> None:
    """A servo without torque goes from the last place towards zero; never is another place believed."""
    true = (1.0 - gone) * last
    found = locate(ServoSection(), TENDON, ticks(true) + turns * table.TICKS_PER_TURN, last)
    if found.certain:
        assert found.displacement == pytest.approx(true, abs=1e-4)
    else:
        assert min(abs(one - true) for one in (found.displacement, *found.others)) < 1e-4
        assert abs(last) > 0.06  # only on a long travel, of which the end and the other side look alike


def test_an_unknown_place_within_the_home_window_is_certain_and_any_other_is_not() -> None:
    assert locate(ServoSection(), TENDON, ticks(0.009), None).certain
    beyond = locate(ServoSection(), TENDON, ticks(0.0593), None)
    assert not beyond.certain
    assert sorted((beyond.displacement, *beyond.others)) == pytest.approx(
        [0.0593 - 2 * math.pi * RADIUS, 0.0593], abs=1e-4
    )


def test_a_spool_that_somebody_turned_is_not_believed() -> None:
    assert not locate(ServoSection(), TENDON, ticks(0.04), 0.0).certain


def test_a_driver_after_a_reboot_beyond_half_a_turn_says_the_true_place(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section())
        first = servos.servos[0]

        def turned_and_rebooted() -> None:
            first.torque = lambda position: 0.0  # the gears hold
            first._shaft.place(ticks(0.0593))
            first.power_up()

        servos.apply(turned_and_rebooted)
        bench.driver.session.bus.close()
        bench.driver = bench.new_driver({1: 0.0593, 2: 0.0, 3: 0.0, 4: 0.0})
        assert bench.driver.displacement[0] == pytest.approx(0.0593, abs=1e-4)
        bench.driver.cycle(time.monotonic(), None)
        assert "tendon 0 (servo 1) stands 59.3 mm from its zero" in bench.driver.report


def test_a_servo_that_is_rebooted_under_the_driver_is_found_again_on_reset(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section())
        first = servos.servos[0]
        first.torque = lambda position: 0.0
        bench.until(lambda one: one.commands.disarmed, (0.0,) * 4, armed=False)
        bench.until(lambda one: one.displacement[0] > 0.059, (0.0593, 0.0, 0.0, 0.0))
        servos.apply(first.power_up)
        bench.until(lambda one: one.phase.value == "off", (0.0593, 0.0, 0.0, 0.0))
        assert "has been rebooted or has lost power" in bench.driver.fault
        bench.driver.reset(time.monotonic())
        assert bench.driver.displacement[0] == pytest.approx(0.0593, abs=2e-3)
        bench.driver.cycle(time.monotonic(), None)
        assert "stands 5" in bench.driver.report


def test_a_servo_beyond_256_turns_is_refused(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        servos.servos[1]._turns = 256
        with pytest.raises(ServoError, match=r"servo 2: counts 256 turns, .*switch its power off and on"):
            DriverBench(servos, tmp_path / "ttyUSB0", section())


def test_a_calibrated_spool_whose_turn_is_shorter_than_the_travel_is_refused(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section())
        bench.driver.session.bus.close()
        small = TENDON.model_copy(update={"spool_radius": 0.008})
        bench.calibration = bench.calibration.model_copy(update={"tendons": (small, *bench.calibration.tendons[1:])})
        with pytest.raises(ServoError, match=r"servo 1: displacement_max = 0.08 m .* more than a turn of the spool"):
            bench.new_driver()


def test_places_are_written_while_tendons_move_and_survive_a_kill(tmp_path: Path) -> None:
    said: list[str] = []
    made = calibration()
    with PlaceKeeper(tmp_path / "places.json", made, said.append) as keeper:
        for step in range(20):
            keeper.keep({1: 0.001 * step})
            time.sleep(0.02)
        kept = read_places(tmp_path / "places.json", made)[1]
    assert kept == pytest.approx(0.019, abs=0.004)
    assert said == []


def test_places_that_cannot_be_written_are_reported_once_and_stop_nothing(tmp_path: Path) -> None:
    said: list[str] = []
    with PlaceKeeper(tmp_path / "nowhere" / "places.json", calibration(), said.append) as keeper:
        for step in range(5):
            keeper.keep({1: 0.01 * step})
            time.sleep(0.02)
    assert len(said) == 1
    assert "cannot be written" in said[0]


def test_places_are_in_the_services_state_directory_where_there_is_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    assert places_file(tmp_path, ServoSection()) == tmp_path / "calibration-places.json"
    monkeypatch.setenv("STATE_DIRECTORY", "/var/lib/tendond/arm1")
    assert places_file(tmp_path, ServoSection()) == Path("/var/lib/tendond/arm1/calibration-places.json")


@pytest.mark.parametrize(("grip", "holds"), [(0.1, True), (0.0, False)])
def test_gears_hold_a_tendon_without_torque_or_yield(tmp_path: Path, grip: float, holds: bool) -> None:
    with emulated(tmp_path) as servos:
        first = servos.servos[0]

        def pulled() -> None:
            first.grip = grip
            first.torque = lambda position: -0.09

        servos.apply(pulled)
        time.sleep(0.3)
        assert (first.position == 2048.0) is holds
