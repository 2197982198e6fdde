"""A point of a simplex is closest to the origin if no corner is beyond its plane."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_geom_ros.geometry._proximity.kernels.cores import simplices

FUNCTIONS = {
    2: simplices.closest_on_segment,
    3: simplices.closest_on_triangle,
    4: simplices.closest_on_tetrahedron,
}


def _closest(corners):
    weights = np.array(FUNCTIONS[len(corners)](*(tuple(c) for c in corners)))
    assert np.all(weights >= 0)
    assert weights.sum() == pytest.approx(1, abs=1e-14)
    return weights @ corners


def _assert_closest(corners):
    v = _closest(corners)
    size = np.abs(corners).max()
    # |v - closest|^2 <= |v|^2 - min v . corner
    excess = v @ v - (corners @ v).min()
    assert excess <= 1e-13 * size * size


@pytest.mark.parametrize('count', [2, 3, 4])
@settings(max_examples=100)
@given(seed=st.integers(0, 2**32 - 1))
def test_random_simplices(count, seed):
    rng = np.random.default_rng(seed)
    _assert_closest(rng.normal(size=(count, 3)) + rng.choice([0, 0.3, 3]) * rng.normal(size=3))


@pytest.mark.parametrize('count', [2, 3, 4])
@settings(max_examples=100)
@given(seed=st.integers(0, 2**32 - 1))
def test_corners_that_coincide_or_stand_in_a_row(count, seed):
    rng = np.random.default_rng(seed)
    corners = rng.integers(-2, 3, size=(count, 3)).astype(float)
    if rng.random() < 0.5:
        corners[-1] = corners[0]
    elif count > 2:
        corners[-1] = 0.5 * (corners[0] + corners[1])
    if np.abs(corners).max() > 0:
        _assert_closest(corners)


def test_the_origin_inside_a_tetrahedron_has_positive_weights_and_distance_zero():
    corners = np.array([[1.0, 0, -1], [-1, 0, -1], [0, 1, 1], [0, -1, 1]])
    weights = np.array(simplices.closest_on_tetrahedron(*(tuple(c) for c in corners)))
    assert np.all(weights > 0)
    assert np.linalg.norm(weights @ corners) <= 1e-15
