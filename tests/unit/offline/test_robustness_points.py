"""Plants that the closed loop is run on, and their configurations."""

import itertools
from collections import Counter

import pytest

from tendond.daemon.control.actuation import lag_factor_of
from tendond.offline.robustness.plants import rig_of
from tendond.offline.robustness.points import AXES, DIRECTIONS, FEEDBACKS, IMPACTS, POINT_SETS, Point, points_of
from tendond.schemas.assumed_rig import SERVO_RATE
from tendond.schemas.config.rig import RigConfig

LAWS = ("backstepping", "sliding_mode")
BASE = RigConfig()


@pytest.mark.parametrize("name", POINT_SETS)
def test_no_plant_is_run_twice(name: str) -> None:
    points = points_of(name, LAWS)
    assert len({point.key for point in points}) == len(points) > 0


def test_the_axes_move_one_thing_at_a_time_for_every_law_and_feedback() -> None:
    points = points_of("axes", LAWS)
    for law, feedback in itertools.product(LAWS, FEEDBACKS):
        own = [point for point in points if (point.law, point.feedback) == (law, feedback)]
        start = Point("axes", law, feedback)
        assert own[0] == start
        for name, values in AXES.items():
            alone = [point for point in own if point == Point("axes", law, feedback, **{name: getattr(point, name)})]
            assert {getattr(point, name) for point in alone} == set(values)
        assert {(one.impact_n, one.impact_direction, one.impact_ms) for one in own if one.impact_n} == set(IMPACTS)


def test_the_corners_have_every_combination_of_extremes() -> None:
    points = points_of("corners", ["backstepping"])
    found = {tuple(getattr(point, name) for name in AXES) for point in points}
    assert found == set(itertools.product(*((values[0], values[-1]) for values in AXES.values())))
    assert len(points) == len(found)


@pytest.mark.parametrize("name", ["corners", "grid"])
def test_no_impact_goes_with_one_value_of_an_axis_only(name: str) -> None:
    points = points_of(name, ["backstepping"])
    impacts = Counter((point.impact_n, point.impact_direction, point.impact_ms) for point in points)
    assert max(impacts.values()) - min(impacts.values()) <= 1
    for axis in AXES:
        values = {getattr(point, axis) for point in points}
        met = {(one.impact_n, one.impact_direction, one.impact_ms, getattr(one, axis)) for one in points}
        assert len(met) == len(impacts) * len(values)


def test_the_grid_is_the_full_factorial() -> None:
    points = points_of("grid", ["backstepping"])
    assert {tuple(getattr(point, name) for name in AXES) for point in points} == set(itertools.product(*AXES.values()))


def test_random_points_repeat_with_their_seed_and_stay_within_the_axes() -> None:
    points = points_of("sample", ["backstepping"], count=40, seed=3)
    assert points == points_of("sample", ["backstepping"], count=40, seed=3)
    assert points != points_of("sample", ["backstepping"], count=40, seed=4)
    for name, values in AXES.items():
        found = [getattr(point, name) for point in points]
        assert set(found) <= set(values) if name == "drive" else values[0] <= min(found) < max(found) <= values[-1]
    assert all(1.0 <= point.impact_n <= 10.0 and point.impact_direction in DIRECTIONS for point in points)


def test_both_laws_meet_the_same_random_plants() -> None:
    first, second = (points_of("sample", [law], count=10, seed=0) for law in LAWS)
    assert [str(point) for point in first] == [str(point) for point in second]


def test_delay_and_lag_are_configured_correctly_unless_the_point_says_otherwise() -> None:
    point = Point("axes", "backstepping", "force", delay_cycles=3, lag_factor=0.8)
    config = rig_of(BASE, point, 0)
    assert config.simulator.mocap.latency == config.observer.delay == pytest.approx(0.03)
    assert config.simulator.servo.lag == config.observer.lag
    assert lag_factor_of(config.observer.lag, config.loop.period) == pytest.approx(0.8)
    for configured, delay, lag in (("delay+1", 4, 0.8), ("delay-1", 2, 0.8), ("lag+0.1", 3, 0.9), ("lag-0.1", 3, 0.7)):
        point = Point("misconfigured", "backstepping", "force", delay_cycles=3, lag_factor=0.8, configured=configured)
        wrong = rig_of(BASE, point, 0)
        assert wrong.simulator.mocap.latency == pytest.approx(0.03)
        assert lag_factor_of(wrong.simulator.servo.lag, 0.01) == pytest.approx(0.8)
        assert wrong.observer.delay == pytest.approx(0.01 * delay)
        assert lag_factor_of(wrong.observer.lag, 0.01) == pytest.approx(lag)


def test_the_plant_is_the_controllers_rod_times_the_factors() -> None:
    point = Point(
        "axes", "sliding_mode", "direct", youngs_factor=0.85, bending_damping_factor=2.0, drag_factor=0.5, load_g=50.0
    )
    config = rig_of(BASE, point, 0)
    assert config.rod == BASE.rod
    assert config.simulator.rod.youngs_modulus == pytest.approx(0.85 * BASE.rod.youngs_modulus)
    assert config.simulator.rod.bending_damping == tuple(2.0 * value for value in BASE.rod.bending_damping)
    assert config.simulator.rod.drag == tuple(0.5 * value for value in BASE.rod.drag)
    assert config.simulator.weight.mass == pytest.approx(0.05)
    assert (config.control.law, config.control.feedback) == ("sliding_mode", "direct")


def test_servos_have_a_rate_limit_that_the_controller_knows_and_tendons_stretch_in_both() -> None:
    config = rig_of(BASE, Point("axes", "backstepping", "offset", drive="displacement"), 0)
    assert config.limits.displacement_rate == config.simulator.servo.rate == SERVO_RATE
    assert config.rod.tendon_stiffness == config.simulator.rod.tendon_stiffness is not None
    assert config.limits.slack > 0.0
    assert config.observer.kind == "offset"


def test_an_impact_comes_when_the_tip_has_tracked_for_long() -> None:
    point = Point("axes", "backstepping", "force", impact_n=3.0, impact_direction="-z", impact_ms=50.0)
    (impact,) = rig_of(BASE, point, 0).simulator.impacts
    assert impact.time == pytest.approx(1.0 + BASE.pretension.duration + 6.0)
    assert (impact.force, impact.duration, impact.place) == ((0.0, 0.0, -3.0), 0.05, 1.0)


def test_noise_depends_on_seed_and_plant_and_on_nothing_else() -> None:
    seeds = {
        rig_of(BASE, Point(part, law, "force", noise_mm=0.1), seed).simulator.seed
        for part, law, seed in itertools.product(("axes", "sample"), LAWS, (0, 1))
    }
    assert len(seeds) == 4
