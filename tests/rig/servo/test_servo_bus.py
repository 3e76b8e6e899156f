"""The wrapper round the real SDK against emulated servos on a real pseudo-terminal."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.protocol import Packet, Receiver, crc16, packet, stuff, unstuff
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import NoReplyError, PortLostError, RefusedError, ServoBus
from tests.rig.servos import BAUDRATE, REPLY_SECONDS, SHORT_SECONDS, emulated

pytestmark = pytest.mark.rig

IDS = (1, 2, 3, 4)


@pytest.fixture
def servos(tmp_path: Path) -> Iterator[EmulatedBus]:
    with emulated(tmp_path) as bus:
        yield bus


@pytest.fixture
def bus(servos: EmulatedBus, tmp_path: Path) -> Iterator[ServoBus]:
    with ServoBus(str(tmp_path / "ttyUSB0"), BAUDRATE, REPLY_SECONDS) as one:
        yield one


def test_crc_and_stuffing_are_the_manuals() -> None:
    """The manual's own examples: a ping of servo 1, and its reply from a servo of model 1030, firmware 38."""
    assert packet(1, b"\x01") == bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
    assert packet(1, bytes.fromhex("55 00 06 04 26")) == bytes.fromhex("FF FF FD 00 01 07 00 55 00 06 04 26 65 5D")
    assert stuff(b"\xff\xff\xfd\x01") == b"\xff\xff\xfd\xfd\x01"
    assert unstuff(stuff(b"a\xff\xff\xfd\xfd")) == b"a\xff\xff\xfd\xfd"
    assert crc16(b"") == 0


def test_a_receiver_finds_packets_in_pieces_and_in_noise() -> None:
    receiver, wire = Receiver(), b"\xff\xffnoise" + packet(3, b"\x02\x84\x00\x04\x00") + b"\xff\xff\xfd\x00\x05"
    found = [one for byte in wire for one in receiver.feed(bytes([byte]))]
    assert found == [Packet(3, 2, b"\x84\x00\x04\x00", True)]
    assert list(receiver.feed(packet(5, b"\x01"))) == [Packet(5, 1, b"", True)]


def test_ping_returns_the_model_or_none_for_an_absent_id(bus: ServoBus) -> None:
    assert bus.ping(2) == table.MODEL_NUMBER
    assert bus.ping(9) is None


def test_registers_are_written_confirmed_and_read(bus: ServoBus) -> None:
    bus.write(2, table.GOAL_POSITION, -70000)
    assert bus.read(2, table.GOAL_POSITION) == -70000
    assert bus.read(1, table.PRESENT_POSITION) == 2048


@pytest.mark.parametrize("fast", [True, False])
def test_one_read_brings_everything_of_every_servo(servos: EmulatedBus, bus: ServoBus, fast: bool) -> None:
    servos.servos[2].voltage, servos.servos[2].temperature = 11.3, 44.0
    bus.write(4, table.TORQUE_ENABLE, 1)
    bus.write_all(table.GOAL_POSITION, {identifier: 2000 + identifier for identifier in IDS})
    time.sleep(0.05)
    readings = bus.read_all(IDS, fast=fast)
    assert [readings[i].goal for i in IDS] == [2001, 2002, 2003, 2004]
    assert [readings[i].torque for i in IDS] == [0, 0, 0, 1]
    assert (readings[3].voltage, readings[3].temperature) == (113, 44)


@pytest.mark.parametrize("fast", [True, False])
@pytest.mark.parametrize("who", IDS)
def test_a_silent_servo_is_an_error_and_never_a_zero(
    servos: EmulatedBus, bus: ServoBus, tmp_path: Path, fast: bool, who: int
) -> None:
    servos.servos[who - 1].silent = True
    bus.close()
    with ServoBus(bus.port, BAUDRATE, SHORT_SECONDS) as impatient:
        with pytest.raises(NoReplyError):
            impatient.read_all(IDS, fast=fast)
        with pytest.raises(NoReplyError, match=f"servo {who}: read Present Position"):
            impatient.read(who, table.PRESENT_POSITION)
    bus.transport.set_baudrate(BAUDRATE)
    if fast:
        assert bus.absent(IDS) == [who]
    servos.servos[who - 1].silent = False
    assert set(bus.read_all(IDS, fast=fast)) == set(IDS)


@pytest.mark.parametrize("fast", [True, False])
def test_a_reply_with_a_wrong_crc_is_an_error(servos: EmulatedBus, bus: ServoBus, fast: bool) -> None:
    servos.corrupt = 1
    with pytest.raises(NoReplyError):
        bus.read_all(IDS, fast=fast)
    assert set(bus.read_all(IDS, fast=fast)) == set(IDS)


@pytest.mark.parametrize("fast", [True, False])
def test_negative_values_that_look_like_a_header_are_read_right(
    servos: EmulatedBus, bus: ServoBus, fast: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Velocity -1 before position -3 is FF FF FF FF FD on the wire: stuffed in plain replies, as it is in fast ones."""
    one = servos.servos[0]
    with servos._lock:
        one._store(table.PRESENT_VELOCITY, -1)
        one._store(table.PRESENT_POSITION, -3)
        monkeypatch.setattr(one, "advance", lambda duration: None)
    assert bus.read_all(IDS, fast=fast)[1].position == -3


def test_a_goal_that_holds_a_header_arrives_one_tick_beside_and_the_bus_stays_in_step(bus: ServoBus) -> None:
    headed = -131073
    assert b"\xff\xff\xfd" in table.GOAL_POSITION.to_bytes(headed)
    bus.write_all(table.GOAL_POSITION, {1: headed, 2: -5, 3: headed + 1, 4: 1_048_575})
    readings = bus.read_all(IDS, fast=True)
    assert [readings[i].goal for i in IDS] == [headed + 1, -5, headed + 1, 1_048_575]
    with pytest.raises(RefusedError, match="looks like a header"):
        bus.write(1, table.GOAL_POSITION, headed)


def test_a_servo_that_refuses_says_what_and_why(bus: ServoBus) -> None:
    bus.write(1, table.TORQUE_ENABLE, 1)
    with pytest.raises(RefusedError, match=r"servo 1: write Operating Mode = 3: .*not available to target address"):
        bus.write(1, table.OPERATING_MODE, 3)
    with pytest.raises(RefusedError, match=r"servo 2: write Goal Position = 1048576: .*out of range"):
        bus.write(2, table.GOAL_POSITION, 1_048_576)


def test_an_unplugged_port_is_named_closed_and_can_be_opened_again(servos: EmulatedBus, bus: ServoBus) -> None:
    servos.unplug()
    with pytest.raises(PortLostError, match="ttyUSB0: the port has gone away"):
        bus.read_all(IDS, fast=True)
    with pytest.raises(PortLostError, match="is not open"):
        bus.read_all(IDS, fast=True)
    with pytest.raises(PortLostError, match="cannot be opened"):
        bus.transport.set_baudrate(BAUDRATE)
    servos.plug()
    bus.transport.set_baudrate(BAUDRATE)
    assert set(bus.read_all(IDS, fast=True)) == set(IDS)


def test_a_port_that_another_process_uses_is_refused(bus: ServoBus) -> None:
    with pytest.raises(PortLostError, match="another process has it open"):
        ServoBus(bus.port, BAUDRATE, REPLY_SECONDS)


def test_a_port_that_does_not_exist_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(PortLostError, match=r"nowhere: cannot be opened: .*No such file") as caught:
        ServoBus(str(tmp_path / "nowhere"), BAUDRATE, REPLY_SECONDS)
    assert "\n" not in str(caught.value)


def test_a_silent_servo_costs_the_reply_timeout_and_not_the_sdks_35_ms(servos: EmulatedBus, tmp_path: Path) -> None:
    servos.servos[0].silent = True
    with ServoBus(str(tmp_path / "ttyUSB0"), BAUDRATE, 0.004) as bus:
        times = []
        for _ in range(20):
            started = time.monotonic()
            assert bus.ping(1) is None
            times.append(time.monotonic() - started)
    assert sorted(times)[5] < 0.02


def test_no_timeout_depends_on_the_wall_clock(
    servos: EmulatedBus, bus: ServoBus, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stepped() -> float:
        raise AssertionError("somebody has asked for the wall clock")

    monkeypatch.setattr(time, "time", stepped)
    assert bus.ping(1) == table.MODEL_NUMBER
    assert set(bus.read_all(IDS, fast=True)) == set(bus.read_all(IDS, fast=False)) == set(IDS)
    servos.servos[0].silent = True
    assert bus.ping(1) is None


def test_a_line_that_never_falls_silent_does_not_keep_a_read(servos: EmulatedBus, bus: ServoBus) -> None:
    ended = threading.Event()

    def babble() -> None:
        import os

        while not ended.is_set():
            assert servos._master is not None
            os.write(servos._master, b"\x00\xff" * 50)
            time.sleep(0.0005)

    servos.servos[0].silent = True
    thread = threading.Thread(target=babble)
    thread.start()
    try:
        assert bus.ping(1) is None
    finally:
        ended.set()
        thread.join()


def test_a_register_is_not_read_from_a_reply_to_another_question(servos: EmulatedBus, tmp_path: Path) -> None:
    """Both registers have four bytes; replies come after the bus has given up, for a while."""
    servos.apply(lambda: servos.servos[0]._store(table.PROFILE_VELOCITY, 77))
    with ServoBus(str(tmp_path / "ttyUSB0"), BAUDRATE, 0.01) as impatient:
        servos.late = 0.018
        with pytest.raises(NoReplyError, match=r"replies came late, by up to \d+ ms: is the adapter's latency timer"):
            impatient.read(1, table.PROFILE_VELOCITY)
        servos.late = 0.0
        impatient.transport.set_reply_timeout(REPLY_SECONDS)
        assert impatient.read(1, table.PRESENT_POSITION) == 2048
        assert impatient.read(1, table.PROFILE_VELOCITY) == 77


def test_the_duration_of_a_read_on_the_wire_is_computed(bus: ServoBus) -> None:
    """15 or so bytes there, 94 back for each servo, ten bits each."""
    assert bus.read_seconds(4) == pytest.approx(1e-5 * (18 + 4 * 94))
