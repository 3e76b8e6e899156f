"""Who may ask: by Host, Origin and token."""

import socket

import pytest

from tendond.cli.dashboard.access import Access, is_loopback


@pytest.mark.parametrize("host", ["localhost:8780", "127.0.0.1:8780", "[::1]:8780", "LOCALHOST", "127.9.9.9:1"])
def test_a_page_on_loopback_is_opened_by_a_name_of_loopback(host: str) -> None:
    assert Access.of("127.0.0.1", guarded=False).objection(host) == ""


@pytest.mark.parametrize(
    "host",
    [None, "", "evil.example", "evil.example:8780", "localhost.evil.example", "192.168.1.5:8780", "[::1", "@", "a b"],
)
def test_a_name_that_was_made_to_resolve_to_loopback_is_refused(host: str | None) -> None:
    assert "open localhost" in Access.of("127.0.0.1", guarded=False).objection(host)


def test_on_the_network_addresses_and_this_computers_name_are_taken_and_other_names_are_not() -> None:
    access = Access.of("0.0.0.0", guarded=False)
    for host in ("192.168.1.5:8780", "[fe80::1]:8780", "localhost", socket.gethostname()):
        assert access.objection(host) == ""
    for host in ("evil.example", f"{socket.gethostname()}.evil.example", ""):
        assert "open it by its address" in access.objection(host)


@pytest.mark.parametrize(
    ("host", "guarded", "needed"),
    [
        ("127.0.0.1", False, False),
        ("localhost", False, False),
        ("::1", False, False),
        ("127.0.0.1", True, True),
        ("0.0.0.0", False, True),
        ("192.168.1.5", False, True),
        ("::", False, True),
        ("", False, True),
        ("bench", False, True),
    ],
)
def test_a_token_is_needed_off_loopback_and_where_the_bus_has_users(host: str, guarded: bool, needed: bool) -> None:
    access = Access.of(host, guarded=guarded)
    assert bool(access.token) == needed
    assert access.admits("") == (not needed)
    assert access.admits(access.token)
    assert not access.admits(None)
    assert not access.admits(f"{access.token}x")
    assert not needed or len(access.token) >= 32
    assert not needed or access.token != Access.of(host, guarded=guarded).token


@pytest.mark.parametrize(
    ("origin", "own"),
    [
        ("http://localhost:8780", True),
        ("http://localhost:8781", False),
        ("http://127.0.0.1:8780", False),
        ("https://localhost:8780", False),
        ("http://localhost:8780.evil.example", False),
        ("http://evil.example", False),
        ("null", False),
        ("", False),
        (None, False),
    ],
)
def test_only_the_page_that_this_server_sent_is_its_own(origin: str | None, own: bool) -> None:
    assert Access.is_own(origin, "localhost:8780") == own
    assert not Access.is_own(origin, None)


def test_loopback_is_told_from_the_network() -> None:
    assert [is_loopback(one) for one in ("::1", "localhost", "127.0.0.2", "::", "10.0.0.1", "")] == [True] * 3 + [
        False
    ] * 3
