"""Support functions: in floats and in full digits, and of points that are on the body."""

import numpy as np
import pytest
from mpmath import mp, mpf

from drake_geom_ros.evidence.random_bodies import random_directions, random_rotation
from drake_geom_ros.evidence.truth import closed_forms
from drake_geom_ros.evidence.truth.supports import DIGITS, posed

SHAPES = [(1, [0.1]), (2, [0.1, 0.2, 0.3]), (3, [0.1, 0.2]), (4, [0.1, 0.2]), (5, [0.1, 0.2, 0.3])]


@pytest.mark.parametrize('shape', SHAPES)
def test_support_points_lie_on_the_surface_at_the_exact_height(shape):
    rng = np.random.default_rng(1)
    R, p = random_rotation(rng), rng.normal(size=3)
    body = posed(shape, R, p)
    n = random_directions(rng, 20)
    for each, point in zip(n, body.points(n), strict=True):
        q = R.T @ (point - p)
        assert float(closed_forms.point_distance(*shape, q)) == pytest.approx(0, abs=1e-15)
        with mp.workdps(DIGITS):
            height = body.exact_height([mpf(float(x)) for x in each])
        assert float(height) == pytest.approx((point - p) @ each, abs=1e-15)
        assert np.linalg.norm(point - p) <= body.size + 1e-15


def test_creases_are_the_edges_that_meet_a_cap():
    body = posed((2, [0.1, 0.2, 0.3]), np.eye(3), np.zeros(3))
    diagonal = np.ones(3) / 3**0.5
    assert len(body.creases(diagonal, 0.01)) == 0
    assert len(body.creases(np.array([1.0, 0.0, 0.0]), 0.01)) == 4
    edge = np.array([1.0, 1.0, 0.0]) / 2**0.5
    ((i, j),) = body.creases(edge, 0.01)
    np.testing.assert_array_equal(body.vertices[i][:2], body.vertices[j][:2])
