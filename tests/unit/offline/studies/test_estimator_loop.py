"""The comparison of loops with the filter and with fixed gains: a short run, and what counts as missed."""

from dataclasses import replace

from tendond.offline.estimator.loop.cases import PLANTS
from tendond.offline.estimator.loop.measure import LoopRun, markdown, missed, run_loop


def test_on_a_soft_late_plant_with_a_mass_the_filters_loop_settles() -> None:
    run = run_loop(PLANTS[1], "backstepping", "kalman", tracking=4.5)
    assert run.reason == ""
    assert run.swing < 2e-3
    assert run.rest < 6e-3


def test_a_loop_that_swings_or_faults_where_the_other_does_not_is_missed() -> None:
    fixed = LoopRun("p", "l", "force", 1e-3, 1e-4, 1e-4)
    known = replace(fixed, kind="kalman", motion=0.5e-3)
    assert missed([fixed, known]) == []
    assert "better" in markdown([fixed, known])
    assert missed([fixed, replace(known, swing=0.05)])
    assert missed([fixed, replace(known, reason="limit cycle")])
    assert missed([replace(fixed, reason="limit cycle"), replace(known, reason="limit cycle")]) == []
