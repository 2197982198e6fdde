"""The plain formulas agree with the oracles of the tests."""

import numpy as np
import pytest
from evidence.hard_cases.construct import turned, unit

from drake_geom_ros.evidence.surfaces import height, support_value, width
from drake_geom_ros.evidence.truth import bodies as truth
from drake_geom_ros.evidence.truth import closed_forms

KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Convex')


@pytest.mark.parametrize('kind', KINDS)
def test_reach_and_height_of_the_extreme_point(kind):
    rng = np.random.default_rng(1)
    for _ in range(20):
        one, n = turned(rng, kind), unit(rng.normal(size=3))
        p = truth.support_point(one, n)
        assert support_value(one, n) == pytest.approx((p - one.p) @ n, abs=1e-14)
        assert height(one, p) == pytest.approx(0.0, abs=1e-14)
        # Before a corner of a hull, or a strong curve, the height is that over one plane.
        assert 1e-4 < height(one, p + 1e-3 * n) < 1.2e-3
        if kind != 'Convex':
            inside = p - 1e-3 * n
            expected = float(closed_forms.point_distance(*one.form, one.R.T @ (inside - one.p)))
            # That of an ellipsoid is the first order of it.
            off = 1e-5 if kind == 'Ellipsoid' else 1e-14
            assert height(one, inside) == pytest.approx(expected, abs=off)


def test_a_half_space_reaches_along_its_normal_only():
    plane = turned(np.random.default_rng(2), 'HalfSpace')
    assert support_value(plane, plane.R[:, 2]) == 0.0
    assert support_value(plane, plane.R[:, 0]) == np.inf
    assert height(plane, plane.p - 2.0 * plane.R[:, 2]) == pytest.approx(-2.0)


def test_the_width_of_a_pair():
    rng = np.random.default_rng(3)
    for _ in range(20):
        a, b = turned(rng, 'Box'), turned(rng, 'Ellipsoid')
        n = unit(rng.normal(size=3))
        apart = truth.support_point(a, -n) - truth.support_point(b, n)
        assert width(a, b, n) == pytest.approx(apart @ n, abs=1e-14)
