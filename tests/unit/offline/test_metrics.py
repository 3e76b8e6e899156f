"""The paper's metrics, counted by hand."""

from collections.abc import Sequence

import numpy as np
import pytest

from tendond.offline.logs.metrics import Metrics, Tracking, metrics


def of_x(x: Sequence[float], target: float = 0.1, axis: int = 0) -> Metrics:
    """Metrics of a series of one component [m]."""
    tip = np.zeros((len(x), 3))
    tip[:, axis] = x
    goal = [0.5, 0.5, 0.5]
    goal[axis] = target
    displacement = np.outer(np.linspace(0.0, 0.02, len(x)), [1.0, -1.0])
    return metrics(
        Tracking(
            ticks=np.arange(len(x)),
            time=np.linspace(0.0, 0.01 * (len(x) - 1), len(x)),
            tip=tip,
            reference=np.tile(goal, (len(x), 1)),
            displacement=displacement,
            tension=1000.0 * np.abs(displacement),
            target=(goal[0], goal[1], goal[2]),
            axes=(axis, 2),
            agonist=0,
        )
    )


def test_metrics_are_those_counted_by_hand() -> None:
    found = of_x([0.0, 0.05, 0.11, 0.12, 0.104, 0.098, 0.1, 0.1])
    assert found.tpl_mm == pytest.approx(50 + 60 + 10 + 16 + 6 + 2 + 0)
    assert found.settling_iterations == 4  # 0.12, sample 3, is the last one outside 0.095 to 0.105
    assert found.overshoot_percent == pytest.approx(20.0)
    assert found.rise_iterations == 2
    assert found.steady_state_error_mm == pytest.approx(100.0 - 682.0 / 8)
    assert found.final_tip_m == (0.1, 0.0, 0.0)
    assert found.final_displacement_m == pytest.approx(0.02)
    assert found.settling_s == pytest.approx(0.04)
    assert found.path_mm == pytest.approx(found.tpl_mm)
    distances = np.hypot(np.array([0.0, 0.05, 0.11, 0.12, 0.104, 0.098, 0.1, 0.1]) - 0.1, 0.5)
    assert found.iae_mm_s == pytest.approx(1000.0 * 0.01 * distances.sum())
    assert found.ripple_mm == pytest.approx(1000.0 * np.std([0.0, 0.05, 0.11, 0.12, 0.104, 0.098, 0.1, 0.1]))
    assert found.tendon_rate_mm_s == pytest.approx(20.0 / 0.07)
    assert (found.peak_tension_n, found.min_tension_n) == pytest.approx((20.0, 0.0))


def test_an_arm_that_begins_far_from_straight_steps_from_where_it_is() -> None:
    """A heavy arm that lies level sags by 0.116 m, and is lifted to 0.025 m below its base without overshoot."""
    found = of_x([-0.116, -0.08, -0.05, -0.033, -0.0295, -0.0247, -0.025], target=-0.025)
    assert found.overshoot_percent == pytest.approx(100.0 * 0.0003 / 0.091)
    assert found.rise_iterations == 3  # 90 % of 0.091 m is at -0.0341 m
    assert found.settling_iterations == 4


def test_a_target_aside_has_no_metrics() -> None:
    def run(first: float, target: float) -> Tracking:
        tip = np.array([[first, 0.0, 0.2], [0.0, 0.05, 0.2], [target, 0.07, 0.18]])
        one = np.zeros((3, 2))
        goal = (target, 0.07, 0.18)
        return Tracking(np.arange(3), np.linspace(0.0, 0.02, 3), tip, tip, one, one, goal, (0, 2), 0)

    assert not run(0.0, 1e-4).has_metrics
    assert run(-0.1, 1e-4).has_metrics
    assert run(0.0, 0.05).has_metrics


def test_the_steady_state_is_the_last_twenty_samples() -> None:
    assert of_x([5.0] * 30 + [0.101, 0.103] * 10).steady_state_error_mm == pytest.approx(2.0)


def test_a_target_on_the_other_side_or_axis_is_no_different() -> None:
    series = np.array([0.01, 0.05, 0.11, 0.12, 0.104, 0.098, 0.1])
    numbers = [
        (found.tpl_mm, found.settling_iterations, found.overshoot_percent, found.rise_iterations)
        for found in (of_x(list(series)), of_x(list(-series), -0.1), of_x(list(series), axis=1))
    ]
    assert numbers[0] == pytest.approx(numbers[1])
    assert numbers[0] == numbers[2]


def test_what_never_happens_has_no_iteration() -> None:
    short = of_x([0.0, 0.05, 0.08])
    assert (short.rise_iterations, short.settling_iterations, short.overshoot_percent) == (None, None, 0.0)
    leaving = of_x([0.0, 0.1, 0.1, 0.12])
    assert (leaving.rise_iterations, leaving.settling_iterations) == (1, None)
    assert of_x([0.1, 0.1]).settling_iterations == 0
