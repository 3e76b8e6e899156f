"""Robots by name rest at their target; a law that cannot run says why."""

import math

from tendond.offline.stability.track import Tracked, track


def test_a_wire_rests_at_its_target_at_50_hz() -> None:
    found = track("rucker-webster-2011", None, 50.0, seconds=3.0)
    assert found.law == "sensitivity"
    assert found.settled, found


def test_a_law_that_the_tendons_do_not_admit_is_no_rest_and_says_why() -> None:
    found = track("till-2019", "mpc", 50.0)
    assert not found.settled
    assert math.isinf(found.missing)
    assert "surround" in found.why


def test_a_tip_that_swings_or_misses_or_has_let_go_does_not_rest() -> None:
    def run(mode: str, missing: float, ripple: float) -> bool:
        return Tracked("nitinol", "backstepping", 100.0, mode, missing, ripple, "").settled

    assert run("tracking", 1e-3, 1e-3)
    assert not run("tracking", 1e-3, 3e-3)
    assert not run("tracking", 3e-3, 1e-3)
    assert not run("fault", 1e-3, 1e-3)
