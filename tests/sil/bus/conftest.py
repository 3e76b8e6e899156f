"""A controller and a simulator that the tests of the bus share."""

from collections.abc import Iterator

import pytest

from tests.sil.bus.live import Live
from tests.sil.rig import rig


@pytest.fixture(scope="package")
def running_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Live]:
    with rig(tmp_path_factory.mktemp("live")) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            yield Live(one, session)


@pytest.fixture
def live(running_rig: Live) -> Iterator[Live]:
    """Yield the running rig, idle and with a measured tip; bring it back there after the test."""
    running_rig.calm()
    yield running_rig
    running_rig.calm()
