"""Access to the page: who may ask for it, by the headers of a request and a token.

A browser lets any page on the web send requests to this computer, and open WebSockets. It names the page that asks in
`Origin`, which has to be this one's (RFC 6455, section 10.2); and a page whose own name was made to resolve to this
computer ("DNS rebinding") has that name in `Host`, which has to be an address, or a name of this computer.
"""

import hmac
import secrets
import socket
from dataclasses import dataclass
from ipaddress import ip_address
from urllib.parse import urlsplit

TOKEN_BYTES = 24
"""Random bytes of a token: 192 bits cannot be guessed."""


@dataclass(frozen=True)
class Access:
    """Rule of access.

    Attributes:
        loopback: listens on loopback only.
        token: that a page has to know; empty: none.
    """

    loopback: bool
    token: str = ""

    @staticmethod
    def of(host: str, *, guarded: bool) -> "Access":
        """Return the rule for an address to listen on.

        Args:
            host: address, or a name of this computer.
            guarded: the bus has users, and this process one's rights: other users of the computer do not.
        """
        loopback = is_loopback(host)
        return Access(loopback, "" if loopback and not guarded else secrets.token_urlsafe(TOKEN_BYTES))

    def objection(self, host: str | None) -> str:
        """Return what is wrong with a request's `Host`, in words; empty for a good one."""
        name = host_name(host or "")
        if self.loopback:
            return "" if is_loopback(name) else f"Host '{name[:64]}' is not this computer's loopback: open localhost"
        if _is_address(name) or name in ("localhost", socket.gethostname().lower()):
            return ""
        return f"Host '{name[:64]}' is not this computer: open it by its address"

    @staticmethod
    def is_own(origin: str | None, host: str | None) -> bool:
        """Return true if the page that asks is the one that this server has sent."""
        return bool(origin and host) and origin == f"http://{host}"

    def admits(self, token: object) -> bool:
        """Return true for the right token, in a time that does not depend on how much of it is right."""
        return isinstance(token, str) and hmac.compare_digest(token.encode(), self.token.encode())


def host_name(host: str) -> str:
    """Return the name or address of a `Host` header, without its port; empty where it has none."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def is_loopback(host: str) -> bool:
    """Return true for an address, or the name, that only this computer reaches."""
    if host.lower() == "localhost":
        return True
    return _is_address(host) and ip_address(host).is_loopback


def _is_address(host: str) -> bool:
    try:
        ip_address(host)
    except ValueError:
        return False
    return True
