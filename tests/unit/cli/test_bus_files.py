"""An unusable file in ZENOH_CONFIG is an invalid configuration for every process."""

import json
import os
import socket
import subprocess
from pathlib import Path

import pytest

from tendond.bus.file import read_bus_file
from tests.rig.tracker import free_port
from tests.unit.cli.commands import TENDOND


@pytest.mark.parametrize(
    ("command", "broken"),
    [
        *(("status", kind) for kind in ("missing", "no json5", "names a missing certificate", "names an empty one")),
        ("run --cycles 1", "missing"),
        ("simulate", "no json5"),
        ("rig vicon", "names a missing certificate"),
        ("arm", "names an empty one"),
        ("watch --once", "missing"),
    ],
)
def test_a_bus_file_that_cannot_be_used_is_a_wrong_configuration_for_every_process(
    command: str, broken: str, tmp_path: Path
) -> None:
    file = tmp_path / "bus.json5"
    if broken == "no json5":
        file.write_text("{ this is not json5")
    elif broken == "names a missing certificate":
        file.write_text('{transport: {link: {tls: {root_ca_certificate: "/nowhere/ca.pem"}}}}')
    elif broken == "names an empty one":
        (tmp_path / "ca.pem").touch()
        file.write_text(f'{{transport: {{link: {{tls: {{root_ca_certificate: "{tmp_path}/ca.pem"}}}}}}}}')
    (tmp_path / "rig.toml").write_text(f"[vicon]\nport = {free_port(socket.SOCK_DGRAM)}\n")
    found = subprocess.run(
        [*TENDOND, *command.split(), "--config", "rig.toml"],
        env={**os.environ, "ZENOH_CONFIG": str(file)}, cwd=tmp_path, capture_output=True, text=True, timeout=60.0,
    )  # fmt: skip
    assert found.returncode == 2, found
    *_, last = found.stderr.splitlines()
    assert last.startswith(f"tendond: ZENOH_CONFIG = {file}: ")
    assert "Traceback" not in found.stderr


def self_signed(folder: Path, name: str) -> None:
    """A certificate and its key, in PEM."""
    curve = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes")
    files = ("-keyout", str(folder / f"{name}.key"), "-out", str(folder / f"{name}.pem"))
    command = ["openssl", "req", "-x509", *curve, "-days", "9", "-subj", f"/CN={name}", *files]
    subprocess.run(command, check=True, capture_output=True)


@pytest.mark.parametrize(
    ("authority", "certificate", "private", "said"),
    [
        ("damaged.pem", "own.pem", "own.key", "root_ca_certificate = {}/damaged.pem: holds no certificate"),
        ("own.key", "own.pem", "own.key", "root_ca_certificate = {}/own.key: holds no certificate"),
        ("own.pem", "damaged.pem", "own.key", "connect_certificate = {}/damaged.pem: holds no certificate"),
        ("own.pem", "own.pem", "other.key", "connect_private_key = {}/other.key: is not the key of {}/own.pem"),
        ("own.pem", "own.pem", "own.pem", "connect_private_key = {}/own.pem: holds no private key"),
        ("own.pem", "own.pem", "own.key", None),
    ],
)
def test_a_bus_file_with_the_wrong_certificate_or_key_is_a_wrong_configuration(
    authority: str, certificate: str, private: str, said: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    self_signed(tmp_path, "own")
    self_signed(tmp_path, "other")
    first, *_, last = (tmp_path / "own.pem").read_text().splitlines()
    (tmp_path / "damaged.pem").write_text(f"{first}\nbm8gY2VydGlmaWNhdGU=\n{last}\n")
    names = {"root_ca_certificate": authority, "connect_certificate": certificate, "connect_private_key": private}
    tls = {name: str(tmp_path / file) for name, file in names.items()}
    (tmp_path / "bus.json5").write_text(json.dumps({"transport": {"link": {"tls": tls}}}))
    monkeypatch.setenv("ZENOH_CONFIG", str(tmp_path / "bus.json5"))
    if said is None:
        read_bus_file()
        return
    found = subprocess.run([*TENDOND, "status"], cwd=tmp_path, capture_output=True, text=True, timeout=60.0)
    assert found.returncode == 2, found
    (line,) = found.stderr.splitlines()
    assert said.replace("{}", str(tmp_path)) in line
