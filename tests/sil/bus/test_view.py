"""`tendond log view` beside a running rig: what is on the bus arrives in Foxglove."""

import pytest

from tests.sil.bus.live import Live
from tests.unit.offline.test_foxglove import viewing

pytestmark = pytest.mark.sil


def test_view_shows_a_live_rig(live: Live) -> None:
    pytest.importorskip("foxglove")
    for topic in ("tip/measured", "rod/shape"):
        with viewing("--config", str(live.rig.config)) as client:
            channels = client.advertised()
            client.subscribe(channels[topic]["id"])
            message = client.message()
            assert "pose" in message or message["entities"][0]["id"] == "rod"
