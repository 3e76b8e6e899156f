"""Bytes from outside give a value or a documented error; `python -m tests.fuzz 1000000` tries more of them."""

from tests.fuzz import run
from tests.fuzz_requests import run as requests


def test_changed_payloads_configurations_and_logs_give_values_or_documented_errors() -> None:
    outcomes = run(20_000, seed=1)
    assert outcomes["bus"].keys() >= {"read", "malformed", "not finite"}
    assert outcomes["configuration"].keys() == {"read", "refused"}
    assert "refused" in outcomes["log"]
    assert sum(sum(counts.values()) for counts in outcomes.values()) >= 20_000


def test_drawn_requests_are_carried_out_or_refused_and_the_cycle_goes_on() -> None:
    outcomes = requests(400, seed=5)
    assert outcomes.keys() >= {
        "plan: made",
        "plan: refused",
        "arm: done",
        "law: refused",
        "stop: done",
        "reset: refused",
    }
