"""A rig behind a router, with the files under deploy/bus: operators on the network ask, and nobody there commands.

The router is Zenoh's own, in this process, from the file that zenohd would be given.
"""

import json
import time
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import open_client
from tendond.daemon.runtime.bus import Hub
from tendond.schemas.config.rig import ConfigError, check_config
from tendond.schemas.keys import STATUS, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.requests import ControlAction
from tendond.schemas.wire import encode
from tests.sil.bus.guarded import POSE, STATE, certificates, gets, put_in_place, until
from tests.sil.rig import Rig

pytestmark = pytest.mark.sil


class Network:
    """Router, a rig's controller that is connected to it, and sessions by name, at one or the other."""

    def __init__(self, folder: Path, patch: pytest.MonkeyPatch) -> None:
        self.folder, self.patch = folder, patch
        put_in_place(folder)
        certificates(folder, ("controller", "router", "operator", "viewer", "vicon"))
        local, outside = (Rig(folder).endpoint.rpartition(":")[2] for _ in range(2))
        self.endpoint, self.outside = f"tcp/127.0.0.1:{local}", f"tls/localhost:{outside}"
        for name, put, wanted in (
            ("router-tls", "tls/0.0.0.0:7447", self.outside),
            ("controller-router", "tls/router.example:7447", self.outside),
        ):
            file = folder / f"{name}.json5"
            text = file.read_text()
            assert put in text
            file.write_text(text.replace(put, wanted))

    def router(self) -> zenoh.Session:
        return zenoh.open(zenoh.Config.from_file(str(self.folder / "router-tls.json5")))

    def hub(self) -> Hub:
        self.patch.setenv("ZENOH_CONFIG", str(self.folder / "controller-router.json5"))
        return Hub(check_config({"rig": {"name": "sil"}, "bus": {"endpoint": self.endpoint}}, "test"))

    def from_outside(self, name: str) -> zenoh.Session:
        self.patch.setenv("ZENOH_CONFIG", str(self.folder / f"{name}-tls.json5"))
        return open_client(self.outside, 10.0)

    def from_inside(self) -> zenoh.Session:
        self.patch.delenv("ZENOH_CONFIG")
        return open_client(self.endpoint, 10.0)


@pytest.fixture
def network(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Network:
    return Network(tmp_path, monkeypatch)


def test_operators_reach_the_rig_through_the_router_and_nothing_else_gets_in(network: Network) -> None:
    with (
        network.router(),
        network.hub() as hub,
        network.from_outside("operator") as operator,
        network.from_outside("viewer") as viewer,
        network.from_outside("vicon") as intruder,
        network.from_inside() as camera,
    ):
        until(lambda: gets(hub, operator, ControlAction.STATUS))
        assert gets(hub, operator, ControlAction.ARM)
        assert gets(hub, viewer, ControlAction.STATUS)
        assert not gets(hub, viewer, ControlAction.ARM)
        status = viewer.declare_subscriber(key("sil", STATUS), zenoh.handlers.FifoChannel(100))
        overheard = viewer.declare_subscriber(key("sil", TENDON_COMMAND), zenoh.handlers.FifoChannel(100))

        def status_arrives() -> bool:
            hub._session.put(key("sil", STATUS), b"{}")
            hub._session.put(key("sil", TENDON_COMMAND), b"{}")
            return status.try_recv() is not None

        until(status_arrives)
        seqs: set[int] = set()
        for outsider in (operator, viewer, intruder):
            outsider.put(key("sil", TIP_POSE), encode(POSE.model_copy(update={"seq": 7})))
            outsider.put(key("sil", TENDON_STATE), encode(STATE))

        def pose_from_inside_arrives() -> bool:
            camera.put(key("sil", TIP_POSE), encode(POSE))
            arrivals = hub.receive()
            assert arrivals.tendon_state is None
            if arrivals.pose is not None:
                seqs.add(arrivals.pose.seq)
            return bool(seqs)

        until(pose_from_inside_arrives)
        for outsider in (operator, viewer, intruder):
            outsider.put(key("sil", TIP_POSE), encode(POSE.model_copy(update={"seq": 7})))
        time.sleep(0.3)
        if (late := hub.receive()).pose is not None:
            seqs.add(late.pose.seq)
        assert seqs == {1}
        assert overheard.try_recv() is None


def test_a_router_without_rules_brings_no_poses_either(network: Network) -> None:
    file = network.folder / "router-tls.json5"
    text = file.read_text()
    file.write_text(text.replace("enabled: true,\n    default", "enabled: false,\n    default"))
    assert file.read_text() != text
    with network.router(), network.hub() as hub, network.from_outside("vicon") as intruder:
        until(lambda: gets(hub, intruder, ControlAction.STATUS))  # it reaches the controller
        for _ in range(50):
            intruder.put(key("sil", TIP_POSE), encode(POSE))
            time.sleep(0.005)
        assert hub.receive().pose is None


def test_a_controller_starts_without_its_router_and_finds_it_later(network: Network) -> None:
    with network.hub() as hub:
        with network.from_inside() as camera:
            until(lambda: camera.put(key("sil", TIP_POSE), encode(POSE)) or hub.receive().pose is not None)
        with network.router(), network.from_outside("operator") as operator:
            until(lambda: gets(hub, operator, ControlAction.STATUS))


def test_a_controller_that_connects_to_a_network_needs_an_access_list(
    network: Network, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Loopback alone does not guard it: what it connects to could bring it commands and poses."""
    open_file = network.folder / "open.json5"
    open_file.write_text(json.dumps({"connect": {"endpoints": [network.outside]}}))
    monkeypatch.setenv("ZENOH_CONFIG", str(open_file))
    with pytest.raises(ConfigError, match="has no access list"):
        Hub(check_config({"bus": {"endpoint": network.endpoint}}, "test"))
