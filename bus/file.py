"""Zenoh configuration named by ZENOH_CONFIG: users, certificates, access; part of the configuration."""

import json
import os
import ssl
from pathlib import Path

import zenoh

from tendond.schemas.config.rig import ConfigError
from tendond.schemas.keys import CONFIG_VARIABLE

FILES = {
    "transport/link/tls": ("root_ca_certificate", "listen_private_key", "listen_certificate", "connect_private_key",
                           "connect_certificate"),
    "transport/auth/usrpwd": ("dictionary_file",),
}  # fmt: skip
"""Keys that name files: where one is missing, Zenoh only reports that it cannot connect."""

PEM = b"-----BEGIN "


def read_bus_file() -> zenoh.Config:
    """Read Zenoh's configuration from that file; Zenoh's defaults where the variable is not set.

    Raises:
        ConfigError: the file, or one that it names, cannot be used.
    """
    path = os.environ.get(CONFIG_VARIABLE)
    if not path:
        return zenoh.Config()
    try:
        found = zenoh.Config.from_file(path)
    except zenoh.ZError as error:
        reason = " ".join(str(error).split(" at /", 1)[0].split())  # a line, without places in Zenoh's source
        raise ConfigError(f"{CONFIG_VARIABLE} = {path}: {reason}; fix it or unset it") from error
    for place, names in FILES.items():
        section = json.loads(found.get_json(place))
        for name in names:
            file = section.get(name)
            if file and (why := _objection(Path(file), pem=place.endswith("tls"))):
                raise ConfigError(f"{CONFIG_VARIABLE} = {path}: {place}/{name} = {file}: {why}; fix it")
    tls = json.loads(found.get_json("transport/link/tls"))
    if why := _tls_objection(tls):
        raise ConfigError(f"{CONFIG_VARIABLE} = {path}: transport/link/tls/{why}; fix it")
    return found


def _objection(file: Path, *, pem: bool) -> str:
    """Return what is wrong with a file named there, in words; empty for a usable one."""
    if not file.exists():
        return "does not exist"
    if not os.access(file, os.R_OK):
        return "cannot be read by this user"
    if pem and PEM not in file.read_bytes():
        return "is not a certificate or key in PEM"
    return ""


def _tls_objection(tls: dict[str, str | None]) -> str:
    """Load certificates and keys as TLS does; return the wrong key and its error, empty where all can be used.

    A base64 body that is damaged, a key in place of a certificate, or a key that is another certificate's has the same
    first line as a good file, and Zenoh only reports that it cannot connect.
    """
    if authority := tls.get("root_ca_certificate"):
        try:
            ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT).load_verify_locations(cafile=authority)
        except ssl.SSLError:
            return f"root_ca_certificate = {authority}: holds no certificate that can be read"
    for side in ("listen", "connect"):
        certificate, private = tls.get(f"{side}_certificate"), tls.get(f"{side}_private_key")
        if not certificate:
            continue
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        try:
            context.load_verify_locations(cafile=certificate)
        except ssl.SSLError:
            return f"{side}_certificate = {certificate}: holds no certificate that can be read"
        if not private:
            continue
        try:
            # A password is never asked for: a daemon has no terminal, and Zenoh takes no locked key.
            context.load_cert_chain(certificate, private, password="")
        except ssl.SSLError as error:
            if error.reason == "KEY_VALUES_MISMATCH":
                return f"{side}_private_key = {private}: is not the key of {certificate}"
            return f"{side}_private_key = {private}: holds no private key that can be read without a password"
    return ""
