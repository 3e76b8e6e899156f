"""Fixtures of the tests with real processes."""

from collections.abc import Iterator

import pytest

from tendond.schemas.config.rig import parse_config
from tests.sil.bench import QUICK, ControllerBench
from tests.sil.peer import Peer
from tests.sil.rig import rig
from tests.sil.supervision import manager as manager


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ControllerBench]:
    with rig(tmp_path_factory.mktemp("faults"), QUICK) as one:
        one.controller()
        config = parse_config(one.config.read_text(), "test")
        with one.session() as session, Peer(config, session) as peer:
            one.until(session, lambda s: s.tip is not None)
            yield ControllerBench(one, session, peer)
            assert not peer.unsafe()
            assert peer.heard
