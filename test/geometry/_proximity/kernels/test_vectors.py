"""Arithmetic of three-vectors, against NumPy and, where squares leave float64, powers of two."""

import math

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels import vectors
from drake_geom_ros.geometry._proximity.tolerances import LARGE_SQUARE, SMALL_SQUARE

A, B = (2.0, -3.0, 5.0), (7.0, 11.0, -13.0)
R = np.arange(1.0, 10.0).reshape(3, 3)  # nine different numbers: no place is taken for another


def test_linear_combinations():
    assert vectors.add(A, B) == (9.0, 8.0, -8.0)
    assert vectors.sub(A, B) == (-5.0, -14.0, 18.0)
    assert vectors.scale(-2.0, A) == (-4.0, 6.0, -10.0)
    assert vectors.add_scaled(A, 2.0, B) == (16.0, 19.0, -21.0)


def test_products():
    assert vectors.dot(A, B) == np.dot(A, B)
    assert vectors.cross(A, B) == tuple(np.cross(A, B))
    assert vectors.rotate(R, A) == tuple(R @ A)
    assert vectors.unrotate(R, A) == tuple(R.T @ A)
    assert [vectors.column(R, k) for k in range(3)] == [tuple(R[:, k]) for k in range(3)]


@pytest.mark.parametrize('exponent', [-1070, -600, -451, -450, -449, 0, 449, 450, 451, 600, 1000])
def test_norm_and_direction_at_every_scale(exponent):
    """A box of 2 by 3 by 6 has a diagonal of 7, and a power of two changes no digit."""
    for x, y, z in ((2, 3, 6), (3, 6, -2), (-6, 2, 3)):
        a = tuple(math.ldexp(c, exponent) for c in (x, y, z))
        assert vectors.norm(a) == pytest.approx(math.ldexp(7.0, exponent), rel=4e-16)
        np.testing.assert_allclose(vectors.unit(a), np.divide((x, y, z), 7.0), rtol=4e-16)
        assert vectors._scaled(a)[0] == math.ldexp(6.0, exponent)


@pytest.mark.parametrize('square', [SMALL_SQUARE, LARGE_SQUARE])
def test_where_the_ways_to_a_length_meet_both_are_right(square):
    side = math.sqrt(square)
    for factor in (1.0 - 2.0**-50, 1.0, 1.0 + 2.0**-50):
        a = (0.0, factor * side, 0.0)
        assert vectors.norm(a) == factor * side
        assert vectors.unit(a) == (0.0, 1.0, 0.0)


def test_the_zero_vector_has_no_length_and_no_direction():
    zero = (0.0, 0.0, 0.0)
    assert vectors.norm(zero) == 0.0
    assert vectors.unit(zero) == zero
    assert vectors._scaled(zero) == (0.0, zero)


@pytest.mark.parametrize(
    ('a', 'axis'),
    [
        ((1.0, 2.0, 3.0), 0),
        ((1.0, 3.0, -2.0), 0),
        ((-3.0, 1.0, 2.0), 1),
        ((2.0, -1.0, 3.0), 1),
        ((2.0, 3.0, 1.0), 2),
        ((3.0, -2.0, -1.0), 2),
        ((1.0, 1.0, 2.0), 0),  # of equal ones the first
        ((1.0, 2.0, 1.0), 0),
        ((2.0, 1.0, 1.0), 1),
        ((1.0, 1.0, 1.0), 0),
        ((0.0, 0.0, 1e-200), 0),
    ],
)
def test_perpendicular_turns_away_from_the_axis_least_along_it(a, axis):
    expected = np.cross(np.divide(a, max(np.abs(a))), np.eye(3)[axis])
    expected /= np.linalg.norm(expected)
    np.testing.assert_allclose(vectors.perpendicular(a), expected, rtol=0, atol=2e-16)
