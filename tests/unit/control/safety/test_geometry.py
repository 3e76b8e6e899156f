"""Distances of a body to half-spaces, boxes and spheres, and their derivatives."""

import numpy as np

from tendond.daemon.control.safety.geometry import REGION, surfaces_of
from tendond.schemas.config.safety.section import SafetySection

ROOM = SafetySection.model_validate(
    {
        "tip_region": {"kind": "box", "low": (-0.3, -0.2, 0.1), "high": (0.3, 0.2, 0.6)},
        "obstacle": [
            {"kind": "sphere", "center": (0.2, 0.0, 0.3), "radius": 0.05},
            {"kind": "half_space", "name": "table", "point": (0.0, 0.0, -0.1), "normal": (0.0, 0.0, 4.0)},
        ],
    }
)


def test_distances_are_those_of_the_shapes() -> None:
    surfaces = surfaces_of(ROOM, 2, body_radius=0.01)
    points = np.array([[0.1, 0.0, 0.3], [0.25, 0.1, 0.5]])
    found = surfaces.measure(points).values
    by = {name: found[surfaces.surface == index] for index, name in enumerate(surfaces.names)}
    np.testing.assert_allclose(by["obstacle 1"], [0.04, np.sqrt(0.05**2 + 0.1**2 + 0.2**2) - 0.06])
    np.testing.assert_allclose(by["table"], [0.39, 0.59])
    np.testing.assert_allclose(np.sort(by[REGION]), np.sort([0.55, 0.05, 0.3, 0.1, 0.4, 0.1]))


def test_a_sphere_for_the_tip_is_stayed_in_and_its_body_does_not_count() -> None:
    section = SafetySection.model_validate({"tip_region": {"kind": "sphere", "center": (0, 0, 0.4), "radius": 0.2}})
    surfaces = surfaces_of(section, 3, body_radius=0.05)
    found = surfaces.measure(np.array([[9.0, 9, 9], [9, 9, 9], [0.0, 0.0, 0.5]]))
    np.testing.assert_allclose(found.values, [0.1])
    np.testing.assert_allclose(found.normals, [[0.0, 0.0, -1.0]])


def test_rows_are_the_derivatives_of_the_distances_by_the_inputs() -> None:
    generator = np.random.default_rng(3)
    surfaces = surfaces_of(ROOM, 4, body_radius=0.02)
    points, jacobians = generator.normal(size=(4, 3)), generator.normal(size=(4, 3, 2))
    rows = surfaces.slopes(surfaces.measure(points).normals, jacobians)
    for column, step in enumerate(1e-6 * np.eye(2)):
        apart = surfaces.measure(points + jacobians @ step).values - surfaces.measure(points - jacobians @ step).values
        np.testing.assert_allclose(rows[:, column], apart / 2e-6, atol=1e-7)


def test_several_shapes_are_measured_at_once() -> None:
    surfaces = surfaces_of(ROOM, 3, body_radius=0.0)
    points = np.random.default_rng(5).normal(size=(7, 3, 3))
    many = surfaces.measure(points)
    for k in range(7):
        one = surfaces.measure(points[k])
        np.testing.assert_allclose(many.values[k], one.values)
        np.testing.assert_allclose(many.normals[k], one.normals)


def test_without_shapes_there_are_no_rows() -> None:
    surfaces = surfaces_of(SafetySection(), 3, body_radius=0.0)
    assert surfaces.count == 0
    assert surfaces.measure(np.zeros((3, 3))).values.shape == (0,)
