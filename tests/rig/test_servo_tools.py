"""What an operator does with servos, on emulated ones: found, set up, calibrated, homed, tightened."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.daemon.cli.servo import (
    RefusedByOperatorError,
    calibrate_servos,
    home_servos,
    pretension_servos,
    scan_servos,
    set_up_servo,
)
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.calibration import (
    CalibrationError,
    load_calibration,
    read_calibration,
    save_calibration,
)
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.tools import ports
from tests.rig.servos import calibration, emulated, hang_springs

pytestmark = pytest.mark.rig


@pytest.fixture
def servos(tmp_path: Path) -> Iterator[EmulatedBus]:
    with emulated(tmp_path, count=2) as bus:
        hang_springs(bus, calibration((1, -1)))
        yield bus


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Of a robot with two tendons; fast, so that the tests are."""
    file = tmp_path / "rig.toml"
    file.write_text(
        f"""
[rod]
tendon_positions = [[0.02, 0.0], [-0.02, 0.0]]
[simulator.rod]
tendon_positions = [[0.02, 0.0], [-0.02, 0.0]]
[limits]
displacement_rate = 0.08
displacement_min = -0.03
displacement_max = 0.08
[servo]
port = "{tmp_path}/ttyUSB0"
answer_timeout = 0.1
slow_rate = 0.05
watchdog = 0.5
"""
    )
    return file


class Operator:
    """Answers questions from a script, and remembers them."""

    def __init__(self, *answers: str) -> None:
        self._answers = list(answers)
        self.asked: list[str] = []

    def __call__(self, question: str) -> str:
        self.asked.append(question)
        if not self._answers:
            raise RefusedByOperatorError("gone away")
        return self._answers.pop(0)


def test_scan_finds_servos_at_whatever_rate_and_changes_nothing(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text(config.read_text().replace("answer_timeout = 0.1", "answer_timeout = 0.03"))
    port = tmp_path / "ttyUSB0"
    with EmulatedBus(port, [EmulatedServo(3, 57600), EmulatedServo(1, 1_000_000)]):
        scan_servos(config, str(port), 3)
    assert capsys.readouterr().out.splitlines() == [
        f"{port}: 57600 bit/s, id 3: XL430-W250-T",
        f"{port}: 1000000 bit/s, id 1: XL430-W250-T",
    ]
    with EmulatedBus(port, []), pytest.raises(DaemonError, match="no servo answers"):
        scan_servos(config, str(port), 1)


def test_each_adapter_is_scanned_once(tmp_path: Path) -> None:
    (tmp_path / "ttyUSB1").touch()
    (tmp_path / "serial" / "by-id").mkdir(parents=True)
    (tmp_path / "serial" / "by-id" / "usb-FTDI").symlink_to("../../ttyUSB1")
    assert ports(tmp_path) == [str(tmp_path / "ttyUSB1")]


def test_a_new_servo_is_set_up_after_confirmation(tmp_path: Path, config: Path) -> None:
    one = EmulatedServo(1, 57600)
    with EmulatedBus(tmp_path / "ttyUSB0", [one]):
        with pytest.raises(RefusedByOperatorError, match="nothing was done"):
            set_up_servo(config, 1, 4, 57600, False, Operator("no"))
        assert (one.id, one.baudrate) == (1, 57600)
        operator = Operator("yes")
        set_up_servo(config, 1, 4, 57600, False, operator)
        assert "set servo 1 to id 4" in operator.asked[0]
    assert (one.id, one.baudrate, one.value(table.OPERATING_MODE)) == (4, 1_000_000, table.EXTENDED_POSITION)
    assert one.value(table.RETURN_DELAY_TIME) == 0


def test_an_id_that_is_taken_or_a_servo_that_holds_is_not_touched(servos: EmulatedBus, config: Path) -> None:
    with pytest.raises(ServoError, match="servo 2: there is one already"):
        set_up_servo(config, 1, 2, None, True, Operator())
    servos.tell(lambda: servos.servos[0]._store(table.TORQUE_ENABLE, 1))
    with pytest.raises(ServoError, match="servo 1: its torque is on"):
        set_up_servo(config, 1, 5, None, True, Operator())
    assert [servo.id for servo in servos.servos] == [1, 2]


def place(servos: EmulatedBus, *ticks: float) -> None:
    def put() -> None:
        for servo, at in zip(servos.servos, ticks, strict=True):
            servo._shaft.place(at)

    servos.tell(put)


def test_calibration_finds_zero_and_sign_and_can_be_gone_on_with(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The springs begin to pull at 2048; servo 1 winds with larger positions, servo 2 with smaller ones."""
    place(servos, 1800.0, 2300.0)
    first = Operator("", "15", "yes")
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, first)
    assert len(read_calibration(tmp_path / "calibration.json").tendons) == 1
    with pytest.raises(CalibrationError, match="unfinished, 1 of 2 tendons"):
        load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    second = Operator("", "nonsense", "", "no")
    calibrate_servos(config, second)
    assert all("Tendon 0" not in question for question in second.asked)
    whole = load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    assert [tendon.sign for tendon in whole.tendons] == [1, -1]
    assert [tendon.zero for tendon in whole.tendons] == pytest.approx([2048, 2048], abs=450)
    assert whole.tendons[0].zero > 2048 > whole.tendons[1].zero
    assert not any(servo.energised for servo in servos.servos)


def test_a_calibration_of_another_rig_or_of_other_servos_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    save_calibration(path, calibration(rig="yours"))
    with pytest.raises(CalibrationError, match="is of rig 'yours', this is 'mine'"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    save_calibration(path, calibration((1, 1, 1, 1, 1), rig="mine"))
    with pytest.raises(CalibrationError, match=r"is for servos \[1, 2, 3, 4, 5\]"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    path.write_text('{"version": 1, "rig"')
    with pytest.raises(CalibrationError, match="is no calibration"):
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


def test_home_brings_every_tendon_to_its_zero_and_switches_off(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    place(servos, 1500.0, 2600.0)
    home_servos(config, False, Operator("yes"))
    assert [servo.position for servo in servos.servos] == pytest.approx([2048, 2048], abs=60)
    assert not any(servo.energised for servo in servos.servos)
    assert "stands -12.6 mm" in capsys.readouterr().out


def test_home_does_not_wind_up_a_tendon_that_pulls_before_its_zero(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1), zero=3500))
    with pytest.raises(ServoError, match=r"servo 1: load 1\d% at -\d.*stopped"):
        home_servos(config, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_pretension_stops_at_the_load_and_stores_the_zero_with_the_old_one_kept(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1), zero=2000))
    place(servos, 1900.0, 2200.0)
    pretension_servos(config, True, True, Operator())
    zeros = [tendon.zero for tendon in read_calibration(tmp_path / "calibration.json").tendons]
    pull = 0.06 * 1.4 / 0.015 / 600.0 / 0.015 / table.TICK  # ticks at which the spring has the wanted load
    assert zeros == pytest.approx([2048 + pull, 2048 - pull], abs=60)
    (kept,) = tmp_path.glob("calibration-2026-01-01T000000Z.json")
    assert [tendon.zero for tendon in read_calibration(kept).tendons] == [2000, 2000]
    assert not any(servo.energised for servo in servos.servos)


def test_pretension_gives_up_where_no_load_comes(servos: EmulatedBus, config: Path, tmp_path: Path) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    servos.tell(lambda: setattr(servos.servos[0], "torque", lambda ticks: 0.0))
    with pytest.raises(ServoError, match="servo 1: no load within 30 mm"):
        pretension_servos(config, False, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_a_servo_that_gets_an_error_on_the_way_is_switched_off(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    servos.tell(lambda: setattr(servos.servos[0], "temperature", 70.0))
    with pytest.raises(ServoError, match="servo 1: 70 degrees"):
        home_servos(config, True, Operator())
    assert not any(servo.energised for servo in servos.servos)
    with ServoBus(str(tmp_path / "ttyUSB0"), 1_000_000, 0.1) as bus:
        assert bus.ping(1) == table.MODEL_NUMBER
