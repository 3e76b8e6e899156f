"""`tendond log view` beside a running rig: what is on the bus arrives in Foxglove."""

from pathlib import Path

import pytest

from tests.sil.rig import rig
from tests.unit.offline.test_foxglove import viewing

pytestmark = pytest.mark.sil


def test_view_shows_a_live_rig(tmp_path: Path) -> None:
    pytest.importorskip("foxglove")
    with rig(tmp_path) as one:
        one.controller()
        one.start("simulate")
        with one.session() as session:
            one.until(session, lambda status: status.tip is not None)
        for topic in ("tip/measured", "rod/shape"):
            with viewing("--config", str(one.config)) as client:
                channels = client.advertised()
                client.subscribe(channels[topic]["id"])
                message = client.message()
                assert "pose" in message or message["entities"][0]["id"] == "rod"
