"""Covariances as people read them, against SciPy's distributions and samples."""

import numpy as np
import pytest
from scipy.stats import chi2

from tendond.daemon.control.estimation.spread import CHI_SQUARE_95, deviation_along, ellipsoid, upper_half, whole

ROOT = np.array([[2.0, 0.0, 0.0], [0.7, 1.0, 0.0], [-0.3, 0.4, 0.5]])
COVARIANCE = ROOT @ ROOT.T


def test_the_bound_is_that_of_the_chi_square_distribution_in_space() -> None:
    assert chi2.ppf(0.95, 3) == pytest.approx(CHI_SQUARE_95, abs=5e-4)


def test_a_matrix_is_its_upper_half() -> None:
    np.testing.assert_array_equal(whole(upper_half(COVARIANCE)), COVARIANCE)


def test_the_ellipsoid_holds_95_percent_of_the_vectors_with_that_covariance() -> None:
    half_axes, axes = ellipsoid(upper_half(COVARIANCE))
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert list(half_axes) == sorted(half_axes)
    samples = np.random.default_rng(0).standard_normal((40_000, 3)) @ ROOT.T
    inside = np.sum((samples @ axes / half_axes) ** 2, axis=1) < 1.0
    assert inside.mean() == pytest.approx(0.95, abs=0.005)


def test_the_deviation_of_a_length_is_that_along_the_vector() -> None:
    half = upper_half(np.diag([4.0, 1.0, 0.25]))
    assert deviation_along(half, np.array([3.0, 0.0, 0.0])) == pytest.approx(2.0)
    assert deviation_along(half, np.array([0.0, 0.0, -0.1])) == pytest.approx(0.5)
    assert deviation_along(half, np.zeros(3)) == pytest.approx(2.0)
