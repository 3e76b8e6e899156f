"""What a page wishes becomes a request, or is refused in a line; nothing old is carried out but a stop."""

from typing import Any

import pytest

from tendond.cli.dashboard.operator import FRESH_JOG_SECONDS, FRESH_SECONDS, Operator, late, request_of
from tendond.daemon.errors import UsageError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.requests import ControlAction

CONFIG = RigConfig()


@pytest.mark.parametrize("action", ["arm", "stop", "reset"])
def test_a_plain_wish_is_that_request(action: str) -> None:
    assert request_of({"do": action, "id": 1, "now": 2.0}, CONFIG).action.value == action


def test_a_reference_a_law_and_gains_are_those_of_the_command_line() -> None:
    reference = request_of({"do": "reference", "settings": ["kind=step", "across=0.3"]}, CONFIG).reference
    assert reference is not None
    assert (reference.kind, reference.across) == ("step", 0.3)
    assert request_of({"do": "law", "law": "sliding_mode"}, CONFIG).law == "sliding_mode"
    wanted = request_of({"do": "set", "settings": ["limits.tension_max=40", "limits.slack=0.001"]}, CONFIG)
    assert wanted.action is ControlAction.SET
    assert wanted.settings == {"limits.tension_max": 40.0, "limits.slack": 0.001}


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({}, "no such request"),
        ({"do": ["arm"]}, "no such request"),
        ({"do": "status"}, "no such request"),
        ({"do": "probe"}, "no such request"),
        ({"do": "law"}, "no such request"),
        ({"do": "law", "law": 3}, "no such request"),
        ({"do": "set", "settings": []}, "no such request"),
        ({"do": "set", "settings": [1]}, "no such request"),
        ({"do": "set", "settings": ["limits.tension_max=nan"]}, "give KEY=VALUE with a number"),
        ({"do": "set", "settings": [f"{'k' * 500}=1"]}, "give KEY=VALUE"),
        ({"do": "reference", "settings": ["across"]}, "give KEY=VALUE"),
        ({"do": "reference", "settings": ["across=300"]}, "did you mean 0.3?"),
        ({"do": "reference", "settings": ["kind=spiral"]}, "reference"),
        ({"do": "reference", "settings": ["file=/etc/passwd"]}, "on the command line only"),
    ],
)
def test_what_is_no_request_is_refused_in_a_line(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError) as refused:
        request_of(asked, CONFIG)
    assert said in str(refused.value)
    assert len(str(refused.value)) < 600


@pytest.mark.parametrize("action", ["arm", "reset", "law", "reference", "set", "jog"])
def test_a_wish_by_an_old_picture_is_refused_and_a_stop_never(action: str) -> None:
    limit = FRESH_JOG_SECONDS if action == "jog" else FRESH_SECONDS
    assert late({"do": action, "now": 100.0}, 100.9 * (action != "jog") + 100.2 * (action == "jog")) == ""
    assert "behind" in late({"do": action, "now": 100.0}, 100.1 + limit)
    assert "behind" in late({"do": action, "now": 100.0}, 99.0)
    for now in (None, "100", True, float("nan"), float("inf")):
        assert late({"do": action, "now": now}, 100.1) != ""
    assert late({"do": "stop"}, 1e9) == ""
    assert late({"do": "stop", "now": 1.0}, 1e9) == ""


@pytest.mark.parametrize("part", [None, "1", True, 1.5, -1.01, float("nan"), float("inf"), [0.5]])
def test_a_speed_by_hand_is_a_part_of_the_largest(part: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tendond.cli.dashboard.operator.late", lambda asked, now: "")
    monkeypatch.setattr("tendond.cli.dashboard.operator.Connection.session", lambda self: pytest.fail("it was sent"))
    assert Operator(CONFIG, "").carry_out({"do": "jog", "part": part}) == (
        False,
        "by hand: a part of the largest speed, from -1 to 1",
    )
