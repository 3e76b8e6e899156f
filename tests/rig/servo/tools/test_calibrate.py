"""Calibration by an operator with a ruler or a camera, on emulated servos."""

import re
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tendond.cli.servo.rig import RefusedByOperatorError
from tendond.cli.servo.tendons import calibrate_servos, home_servos
from tendond.drivers.dynamixel.calibration import CalibrationError, load_calibration, read_calibration, save_calibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.places import Places, read_places, write_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.tools.calibrate import MismatchError
from tests.rig.servo.tools.operating import Operator, displaced, mark, place
from tests.rig.servos import calibration

pytestmark = pytest.mark.rig


def test_calibration_finds_id_sign_spool_and_zero_and_can_be_resumed(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The springs begin to pull at 2048; servo 1 pulls towards larger positions, servo 2 towards smaller ones."""
    place(servos, 1800.0, 2300.0)
    first = Operator("", "again", "0", "yes", "", mark(servos, 0, 0.015))
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, first)
    assert len(read_calibration(tmp_path / "calibration.json").tendons) == 1
    with pytest.raises(CalibrationError, match="unfinished, 1 of 2 tendons"):
        load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    second = Operator("", "1", "no", "", "nonsense", mark(servos, 1, 0.015))
    calibrate_servos(config, second)
    assert all("Tendon 0" not in question for question in second.asked)
    whole = load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    assert [tendon.sign for tendon in whole.tendons] == [1, -1]
    assert [tendon.spool_radius for tendon in whole.tendons] == pytest.approx([0.015, 0.015], rel=0.03)
    assert [tendon.zero for tendon in whole.tendons] == pytest.approx([2048, 2048], abs=450)
    assert whole.tendons[0].zero > 2048 > whole.tendons[1].zero
    assert not any(servo.energised for servo in servos.servos)
    assert read_places(tmp_path / "calibration-places.json", whole) == {1: 0.0, 2: 0.0}


def test_a_spool_of_another_size_than_configured_is_noticed_by_the_tendons_travel(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    place(servos, 1950.0, 2300.0)
    operator = Operator("", "0", "yes", "", mark(servos, 0, 0.03), "no", "", mark(servos, 0, 0.03), "yes")
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, operator)
    (found,) = read_calibration(tmp_path / "calibration.json").tendons
    assert found.spool_radius == pytest.approx(0.03, rel=0.03)
    assert "That makes a radius of 3" in operator.asked[5]
    assert "servo.spool_radius is 15 mm" in operator.asked[5]


def test_a_servo_that_moves_another_tendon_is_named_and_nothing_is_kept(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    place(servos, 1800.0, 2300.0)
    with pytest.raises(MismatchError, match=r"servo 1 moved tendon 1, not tendon 0: fix servo.ids"):
        calibrate_servos(config, Operator("", "1"))
    assert not (tmp_path / "calibration.json").exists()
    assert not any(servo.energised for servo in servos.servos)


def test_a_torn_calibration_is_set_aside_and_the_remedy_is_named(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "calibration.json").write_text('{"version": 1, "rig"')
    with pytest.raises(CalibrationError, match="run 'tendond servo calibrate', which sets it aside"):
        home_servos(config, True, Operator())
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, Operator())
    (kept,) = tmp_path.glob("calibration-*-unreadable.json")
    assert kept.read_text() == '{"version": 1, "rig"'
    assert f"set aside as {kept.name}" in capsys.readouterr().err


def test_a_servo_that_a_killed_calibration_left_on_is_taken_over(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place(servos, 1800.0, 2300.0)
    servos.apply(servos.servos[0]._switch_on)
    servos.apply(lambda: servos.servos[0]._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED))
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, Operator("", "0", "yes", "", mark(servos, 0, 0.015)))
    assert "servo 1: was left on by an interrupted run, is off now" in capsys.readouterr().out
    assert len(read_calibration(tmp_path / "calibration.json").tendons) == 1
    servos.apply(servos.servos[1]._switch_on)
    servos.apply(lambda: setattr(servos.servos[1], "torque", lambda ticks: 0.5))
    with pytest.raises(ServoError, match=r"servo 2: holds a load of 3\d%: .*servo reboot 2"):
        calibrate_servos(config, Operator())
    assert servos.servos[1].energised


def test_a_calibration_of_another_rig_or_of_other_servos_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    save_calibration(path, calibration(rig="yours"))
    with pytest.raises(CalibrationError, match="is of rig 'yours', this is 'mine'"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    save_calibration(path, calibration((1, 1, 1, 1, 1), rig="mine"))
    with pytest.raises(CalibrationError, match=r"is for servos \[1, 2, 3, 4, 5\]"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    path.write_text('{"version": 1, "rig"')
    with pytest.raises(CalibrationError, match="is not a calibration"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    path.unlink()
    with pytest.raises(CalibrationError, match="tendond servo calibrate"):
        load_calibration(path, "mine", (1, 2, 3, 4))


def test_a_calibration_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.json"
    save_calibration(path, calibration(rig="first"))

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(CalibrationError, match="cannot be written: No space left"):
        save_calibration(path, calibration(rig="second"))
    assert read_calibration(path).rig == "first"
    assert [file.name for file in tmp_path.iterdir()] == ["c.json"]


def test_places_of_another_calibration_are_not_believed(tmp_path: Path) -> None:
    made = calibration((1, -1))
    path = tmp_path / "places.json"
    write_places(path, made, {1: 0.01, 2: -0.02})
    assert read_places(path, made) == {1: 0.01, 2: -0.02}
    assert read_places(path, made.model_copy(update={"date": "2026-02-02T00:00:00+00:00"})) == {}
    path.write_text(path.read_text()[:20])
    assert read_places(path, made) == {}
    assert Places(rig="a", calibration="b").displacement == {}


class FakeCamera:
    """Camera that measures the bend made by the servos' shafts on spools of 15 mm; or with tendons elsewhere.

    Args:
        servos: emulated servos, by whose shafts the rod bends.
        positions: positions of the tendons in the cross-section [m].
    """

    def __init__(self, servos: EmulatedBus, positions: tuple[tuple[float, float], ...]) -> None:
        self._servos = servos
        self._positions = positions

    def __enter__(self) -> "FakeCamera":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def bend(self, meanwhile: Callable[[], object] = lambda: None) -> tuple[float, float]:
        for _ in range(60):  # as long as a real one looks: the servo must not stop meanwhile
            meanwhile()
            time.sleep(0.005)
        bend = [0.0, 0.0]
        for (x, y), displacement in zip(self._positions, displaced(self._servos), strict=True):
            squared_radius = x * x + y * y
            bend[0] += max(0.0, displacement) * x / squared_radius
            bend[1] += max(0.0, displacement) * y / squared_radius
        return bend[0], bend[1]


@pytest.mark.parametrize(
    ("positions", "complaint"),
    [
        (((0.02, 0.0), (-0.02, 0.0)), ""),
        (((-0.02, 0.0), (0.02, 0.0)), "the tip bent towards tendon 1: is the servo's id, or its sign, correct?"),
        (((0.045, 0.0), (-0.045, 0.0)), "is servo.spool_radius correct"),
    ],
)
def test_a_camera_confirms_each_tendon_or_says_what_does_not_fit(
    servos: EmulatedBus,
    config: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    positions: tuple[tuple[float, float], ...],
    complaint: str,
) -> None:
    place(servos, 2000.0, 2100.0)
    camera = FakeCamera(servos, positions)
    monkeypatch.setattr("tendond.drivers.dynamixel.tools.calibrate.Camera", lambda _: camera)
    operator = Operator("", "0", "yes", "", "1", "no")  # nobody is asked for a ruler
    if complaint:
        with pytest.raises(MismatchError, match=re.escape(complaint)):
            calibrate_servos(config, operator)
    else:
        calibrate_servos(config, operator)
        said = capsys.readouterr().out
        assert said.count("the camera measured") == 2
        assert said.count("id, sign, radius fit") == 2
    assert not any(servo.energised for servo in servos.servos)
