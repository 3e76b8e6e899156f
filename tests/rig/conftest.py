"""Fixtures of the tests on emulated devices."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.rig.bench import DriverBench, section
from tests.rig.servos import emulated
from tests.sil.supervision import manager as manager


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[DriverBench]:
    with emulated(tmp_path) as servos:
        one = DriverBench(servos, tmp_path / "ttyUSB0", section())
        yield one
        one.driver.session.bus.close()
