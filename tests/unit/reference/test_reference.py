"""References: targets that the rod can reach, trajectories, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from tendond.cli.common import load_config
from tendond.daemon.control.reference.load_offset import moved_point
from tendond.daemon.control.reference.planar import PlanarReference, plan_in_plane
from tendond.daemon.errors import TargetError
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.rig import ConfigError, RigConfig, parse_config

DEFAULT = RigConfig()
ROD = rod_from_section(DEFAULT.rod, DEFAULT.loop.period)


def build(text: str = "", control: str = "") -> PlanarReference:
    return plan_in_plane(parse_config(f"[reference]\n{text}\n[control]\n{control}", "test"), ROD)


def rest(tension: float) -> np.ndarray:
    """Tip of the resting rod [m], shape (3,)."""
    return ROD.tip(ROD.solve_static([tension, 0.0, 0.0, 0.0])).position


def test_the_curve_goes_through_resting_tips_within_a_hundredth_of_a_millimetre() -> None:
    curve = build().curve
    for tension in (0.05, 0.7, 3.3, 17.0, 41.0, 59.0):
        arc = float(np.interp(tension, curve.tension, curve.arc))
        nearest = float(curve.nearest(rest(tension)[[0, 2]])[0])
        gaps = [
            np.linalg.norm(curve.at(a)[0] - rest(tension)[[0, 2]])
            for a in np.linspace(nearest - 0.01, nearest + 0.01, 401)
        ]
        assert min(gaps) < 5e-5
        assert abs(arc - nearest) < 5e-3


@pytest.mark.parametrize("length", [0.5, 0.25])
def test_a_target_is_reachable_within_a_five_hundredth_of_the_length_from_the_curve(length: float) -> None:
    rod = f"[rod]\nlength = {length}\n"
    config = parse_config(f"{rod}[reference]\nacross = {0.4 * length}\n", "test")
    model = rod_from_section(config.rod, config.loop.period)
    found = plan_in_plane(config, model)
    assert found.arc is not None
    (x, z), (dx, dz), _ = found.curve.at(found.arc)
    for beside, reachable in ((0.0018, True), (0.0022, False)):
        place = [float(x - beside * length * dz), 0.0, float(z + beside * length * dx)]  # along the normal
        wanted = parse_config(f"{rod}[reference]\nposition = {place}\n", "test")
        if reachable:
            assert plan_in_plane(wanted, model, found.curve).arc == pytest.approx(found.arc, abs=0.01 * length)
        else:
            with pytest.raises(TargetError, match="beyond what the rod can reach"):
                plan_in_plane(wanted, model, found.curve)


def test_one_x_has_two_shapes_and_the_branch_names_the_one() -> None:
    """x = 340 mm: z is 47.5 mm where the rod is bent by 165 degrees, 266 mm at 106 degrees (the converged rod's)."""
    at_165, at_106 = build("across = 0.34"), build('across = 0.34\nbranch = "below_135"')
    assert at_165.target == pytest.approx((0.34, 0.0, 0.0475), abs=1e-4)
    assert at_106.target == pytest.approx((0.34, 0.0, 0.266), abs=5e-4)


def test_an_angle_and_the_direction_that_it_gives_are_the_same_target() -> None:
    angle = build("angle = 2.0")
    direction = build(f"direction = [{math.sin(2.0)}, 0.0, {math.cos(2.0)}]")
    assert angle.target == pytest.approx(direction.target, abs=1e-9)
    arc = angle.arc
    assert arc is not None
    tangent = np.interp(arc, angle.curve.arc, angle.curve.angle)
    assert tangent == pytest.approx(2.0, abs=1e-4)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("across = 0.4", r"across = 0\.4 is beyond .* the nearest is 0\.3\d+ m, the tip at \(across, along\) = \(0\.3"),
        ("across = -0.2", r"across = -0\.2 is beyond .* the nearest is -0\.027\d m"),
        ("position = [0.34, 0.0, 0.0]", r"position = .* the nearest is the tip at \(across, along\) = \(0\.3"),
        ("angle = 5.0", r"angle = 5 is beyond .* the nearest is 4\.0\d+ rad"),
        ("direction = [0.0, 1.0, 0.0]", "must lie in the bending plane"),
    ],
)
def test_what_no_shape_reaches_is_refused_with_the_nearest_that_one_does(text: str, match: str) -> None:
    with pytest.raises(TargetError, match=match) as caught:
        build(text)
    assert "\n" not in str(caught.value)


def test_an_unreachable_position_can_be_tracked_when_asked_for() -> None:
    """The paper's own target, (340, 0) mm."""
    reference = build('position = [0.34, 0.0, 0.0]\nunreachable = "track"\npath = "direct"')
    assert reference.target == (0.34, 0.0, 0.0)
    assert reference.at(10.0).position == pytest.approx((0.34, 0.0, 0.0), abs=1e-12)


def test_the_papers_reference_is_its_formula() -> None:
    reference = build('position = [0.34, 0.0, 0.0475]\npath = "direct"\nrate = 20.0')
    for time in (0.0, 0.03, 0.2):
        point, decay = reference.at(time), math.exp(-20.0 * time)
        assert point.position == pytest.approx((0.34 * (1.0 - decay), 0.0, 0.0475))
        assert point.velocity == pytest.approx((0.34 * 20.0 * decay, 0.0, 0.0))
        assert point.acceleration == pytest.approx((-0.34 * 400.0 * decay, 0.0, 0.0))


TRAJECTORIES = {
    "exponential": 'across = 0.34\nkind = "exponential"\nrate = 7.0',
    "minimum jerk": 'across = 0.34\nkind = "minimum_jerk"\nduration = 0.7',
    "direct minimum jerk": 'across = 0.34\nkind = "minimum_jerk"\nduration = 0.7\npath = "direct"',
    "samples": 'kind = "samples"\nunreachable = "track"\n'
    "samples = [[0.0, 0.0, 0.5], [0.3, 0.1, 0.47], [0.8, 0.3, 0.3]]",
}


@pytest.mark.parametrize("name", list(TRAJECTORIES))
def test_velocity_and_acceleration_are_the_derivatives_of_the_position(name: str) -> None:
    reference, h = build(TRAJECTORIES[name]), 1e-5
    for time in (0.11, 0.32, 0.55):
        before, now, after = (np.array(reference.at(t).position) for t in (time - h, time, time + h))
        point = reference.at(time)
        np.testing.assert_allclose(point.velocity, (after - before) / (2 * h), atol=1e-5)
        np.testing.assert_allclose(point.acceleration, (after - 2 * now + before) / h**2, atol=2e-2)


def test_a_trajectory_along_the_curve_starts_where_the_pretensioned_arm_rests_and_ends_at_the_target() -> None:
    reference = build('kind = "minimum_jerk"\nduration = 0.5')
    start = rest(DEFAULT.pretension.tension)
    assert reference.at(0.0).position == pytest.approx(tuple(start), abs=1e-3)
    assert reference.at(9.0).position == pytest.approx(reference.target, abs=1e-12)
    assert reference.at(9.0).velocity == (0.0, 0.0, 0.0)
    moved = moved_point(reference.at(9.0), 0.01)
    assert moved.position[2] == pytest.approx(reference.target[2] + 0.01)
    assert (moved.position[:2], moved.velocity, moved.target) == (
        reference.target[:2],
        (0.0, 0.0, 0.0),
        reference.target,
    )


def test_a_step_is_at_its_target_at_once() -> None:
    assert build('kind = "step"').at(0.0).position == pytest.approx(build().target)


def test_samples_come_from_a_file_beside_the_configuration(tmp_path: Path) -> None:
    curve = build().curve
    points = [curve.at(arc)[0] for arc in (0.05, 0.2, 0.35)]
    rows = "".join(f"{0.5 * i},{p[0]:.9f},{p[1]:.9f}\n" for i, p in enumerate(points))
    (tmp_path / "tip.csv").write_text("time,x,z\n" + rows)
    (tmp_path / "rig.toml").write_text('[reference]\nkind = "samples"\nfile = "tip.csv"\n')
    reference = plan_in_plane(load_config(tmp_path / "rig.toml"), ROD)
    assert reference.at(0.5).position == pytest.approx((points[1][0], 0.0, points[1][1]), abs=1e-6)
    (tmp_path / "tip.csv").write_text("time,x,z\n0.0,0.1\n")
    with pytest.raises(ConfigError, match=r"tip\.csv:2: must be three numbers"):
        load_config(tmp_path / "rig.toml")
    (tmp_path / "tip.csv").unlink()
    with pytest.raises(ConfigError, match=r"tip\.csv: cannot be read"):
        load_config(tmp_path / "rig.toml")


def test_samples_off_the_curve_are_refused_by_number() -> None:
    with pytest.raises(TargetError, match=r"samples\[1\] = .* mm from where the tip can rest"):
        build('kind = "samples"\nsamples = [[0.0, -0.0279, 0.4987], [1.0, 0.3, 0.45]]')


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("across = 0.1\nangle = 1.0", "give one target, not across and angle"),
        ('kind = "samples"\nsamples = [[0.0, 0.0, 0.5]]', "needs a file, or two samples"),
        ('kind = "samples"\nsamples = [[0.0, 0.0, 0.5], [0.0, 0.1, 0.5]]', "must start at 0 and increase"),
        ('across = 0.1\nfile = "a.csv"', "samples and file go with kind"),
    ],
)
def test_a_reference_that_says_two_things_is_refused(text: str, match: str) -> None:
    with pytest.raises(ConfigError, match=match):
        parse_config(f"[reference]\n{text}", "test")


def test_the_other_plane_and_the_other_side_work_alike() -> None:
    """Gravity is along -x, so that in plane yz the curve is symmetric to its mirror image."""
    right = build("across = 0.2\nunreachable = 'track'", 'plane = "yz"\nagonist = 1')
    left = build("across = -0.2\nunreachable = 'track'", 'plane = "yz"\nagonist = 3')
    assert right.target[1] == pytest.approx(-left.target[1])
    assert right.target[2] == pytest.approx(left.target[2], abs=1e-6)
    assert right.target[0] == left.target[0] == 0.0
