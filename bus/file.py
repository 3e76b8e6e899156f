"""The Zenoh configuration that ZENOH_CONFIG names: users, certificates, access; part of the configuration."""

import json
import os
from pathlib import Path

import zenoh

from tendond.schemas.config.rig import ConfigError
from tendond.schemas.keys import CONFIG_VARIABLE

FILES = {
    "transport/link/tls": ("root_ca_certificate", "listen_private_key", "listen_certificate", "connect_private_key",
                           "connect_certificate"),
    "transport/auth/usrpwd": ("dictionary_file",),
}  # fmt: skip
"""Keys that name files: Zenoh says of a client's that nobody can be connected to, where one is missing."""

PEM = b"-----BEGIN "


def read_bus_file() -> zenoh.Config:
    """Zenoh's configuration in that file; Zenoh's defaults where the variable is not set.

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
        raise ConfigError(f"{CONFIG_VARIABLE} = {path}: {reason}; mend it or unset it") from error
    for place, names in FILES.items():
        section = json.loads(found.get_json(place))
        for name in names:
            file = section.get(name)
            if file and (why := _objection(Path(file), pem=place.endswith("tls"))):
                raise ConfigError(f"{CONFIG_VARIABLE} = {path}: {place}/{name} = {file}: {why}; mend it")
    return found


def _objection(file: Path, *, pem: bool) -> str:
    """What is wrong with a file that is named there, in words; empty for one that can be used."""
    if not file.exists():
        return "is not there"
    if not os.access(file, os.R_OK):
        return "may not be read by this user"
    if pem and PEM not in file.read_bytes():
        return "is no certificate or key in PEM"
    return ""
