"""Sockets for Tracker's packets: unicast, broadcast or multicast."""

import fcntl
import socket
import struct
from contextlib import suppress
from ipaddress import IPv4Interface

from tendond import TendondError
from tendond.schemas.config.vicon import ViconSection

EVERYWHERE, EVERYONE = "0.0.0.0", "255.255.255.255"
SIOCGIFADDR, SIOCGIFNETMASK = 0x8915, 0x891B
"""Requests of netdevice(7)."""

IP_PKTINFO = 8
"""Option of ip(7): each packet carries its network card; Python has no name for it before 3.14."""

IFREQ_BYTES = 40
IFREQ_ADDRESS = slice(20, 24)


class ViconError(TendondError):
    """Packets of the motion capture cannot be received."""


def listen(section: ViconSection) -> list[tuple[socket.socket, int]]:
    """Open the sockets; each with the index of the card on which alone it listens, 0 for any.

    A socket bound to a card's address does not receive broadcasts, so there are two more for them. The first is bound
    without sharing: a port that another driver has is refused.

    Raises:
        ViconError: an address cannot be listened on, or a group not be joined.
    """
    sockets: list[tuple[socket.socket, int]] = []
    try:
        sockets.append((_bound(section.address, section.port, section.key, shared=False), 0))
        if section.address != EVERYWHERE and (card := _card(section.address)) is not None:
            index, broadcast = card
            for address in (broadcast, EVERYONE):
                sockets.append((_bound(address, section.port, section.key, shared=True), index))
        if section.multicast:
            sockets.append((_member(section.multicast, section.address, section.port, section.key), 0))
    except ViconError:
        close(sockets)
        raise
    return sockets


def close(sockets: list[tuple[socket.socket, int]]) -> None:
    """Free the port."""
    for one, _ in sockets:
        one.close()


def _bound(address: str, port: int, key: str, *, shared: bool) -> socket.socket:
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        if shared:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        one.setsockopt(socket.IPPROTO_IP, IP_PKTINFO, 1)
        one.bind((address, port))
    except OSError as error:
        one.close()
        raise ViconError(
            f"cannot listen on UDP {address}:{port}: {error.strerror}; is another driver running"
            f" there? Else fix {key}.address or {key}.port"
        ) from error
    return one


def _member(group: str, address: str, port: int, key: str) -> socket.socket:
    """Return a membership of a multicast group, on the card with the address."""
    one = _bound(group, port, key, shared=True)
    try:
        membership = socket.inet_aton(group) + socket.inet_aton(address)
        one.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
    except OSError as error:
        one.close()
        raise ViconError(
            f"cannot join the multicast group {group} on {address}: {error.strerror}; set {key}.address to the address"
            " of the network card to which Tracker is connected"
        ) from error
    return one


def _card(address: str) -> tuple[int, str] | None:
    """Index and broadcast address of the network card with this address; none where no card has it first."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for index, name in socket.if_nameindex():
            request = struct.pack(f"{IFREQ_BYTES}s", name.encode())
            with suppress(OSError):  # a card without an address
                found = [
                    socket.inet_ntoa(fcntl.ioctl(probe, code, request)[IFREQ_ADDRESS])
                    for code in (SIOCGIFADDR, SIOCGIFNETMASK)
                ]
                if found[0] == address:
                    return index, str(IPv4Interface("/".join(found)).network.broadcast_address)
    return None
