"""A guarded bus: the files under deploy/bus, the rig's name and paths put in, and sessions with their rights."""

import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import pytest
import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.daemon.runtime.bus import Hub
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import TendonState, TipPose
from tendond.schemas.requests import ControlAction, ControlReply
from tests.sil.rig import PATIENCE_SECONDS, Rig

SERVERS = {"controller", "router"}
EXAMPLES = Path(__file__).parents[3] / "deploy" / "bus"
POSE = TipPose(seq=1, stamp_ns=0, position=(0.0, 0.0, 0.5), orientation=(1.0, 0.0, 0.0, 0.0))
STATE = TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * 4, tension=(0.0,) * 4)


def put_in_place(folder: Path) -> None:
    """Install the examples as an administrator would for a rig 'sil'."""
    for file in EXAMPLES.iterdir():
        text = file.read_text().replace("/etc/tendond/bus", str(folder)).replace('"rig/', '"sil/')
        (folder / file.name).write_text(text)


def certificates(folder: Path, names: Sequence[str] = ("controller", "vicon", "viewer")) -> None:
    """Make an authority and the certificates of `names`, by the README's commands."""

    def openssl(*arguments: str) -> None:
        subprocess.run(["openssl", *arguments], cwd=folder, check=True, capture_output=True)

    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")
    openssl("req", "-x509", *curve, "-days", "9", "-subj", "/CN=rig-ca", "-keyout", "ca.key", "-out", "ca.pem")
    for name in names:
        openssl("req", *curve, "-subj", f"/CN={name}", "-keyout", f"{name}.key", "-out", f"{name}.csr")
        (folder / f"{name}.ext").write_text(f"subjectAltName=DNS:{'localhost' if name in SERVERS else name}\n")
        signed = ("-CA", "ca.pem", "-CAkey", "ca.key", "-CAcreateserial", "-days", "9", "-extfile", f"{name}.ext")
        openssl("x509", "-req", "-in", f"{name}.csr", *signed, "-out", f"{name}.pem")
        text = (folder / "client-tls.json5").read_text()
        if name not in SERVERS:
            (folder / f"{name}-tls.json5").write_text(text.replace("client.", f"{name}."))


def until(happens: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not happens():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def gets(hub: Hub, session: zenoh.Session, action: ControlAction) -> bool:
    """Return whether the controller hears a request and its reply comes."""
    replies: list[ControlReply] = []

    def run() -> None:
        with suppress(BusError):
            replies.append(ask(session, "sil", action))

    thread = threading.Thread(target=run)
    thread.start()
    while thread.is_alive():
        hub.requests.receive(time.monotonic())
        for question in hub.requests.questions:
            question.reply(ControlReply(done=True, message="yes"))
        if (other := hub.requests.next(time.monotonic())) is not None:
            assert other.request.action is action
            other.reply(ControlReply(done=True, message="yes"))
        time.sleep(0.005)
    thread.join()
    return bool(replies)


class Guarded:
    """Hub with access control, and sessions by name."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch, protocol: str = "tcp") -> None:
        self.folder, self.patch, self.protocol = folder, monkeypatch, protocol
        put_in_place(folder)
        port = Rig(folder).endpoint.rpartition(":")[2]
        self.endpoint = f"{protocol}/localhost:{port}"
        monkeypatch.setenv(
            "ZENOH_CONFIG", str(folder / ("controller.json5" if protocol == "tcp" else "controller-tls.json5"))
        )

    @property
    def suffix(self) -> str:
        return "" if self.protocol == "tcp" else "-tls"

    def hub(self, **sections: object) -> Hub:
        return Hub(check_config({"rig": {"name": "sil"}, "bus": {"endpoint": self.endpoint}, **sections}, "test"))

    def session(self, name: str, timeout: float = 10.0) -> zenoh.Session:
        self.patch.setenv("ZENOH_CONFIG", str(self.folder / f"{name}{self.suffix}.json5"))
        return open_client(self.endpoint, timeout)
