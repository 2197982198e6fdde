import numpy as np
import pytest
from oracles.core_pairs import core_pair, radius_of
from oracles.forms import ALIGNED, signed_distance

from drake_geom_ros.geometry._proximity.kernels.revolution import revolution
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID
from truth.bodies.random_bodies import random_rotation

BODIES = [
    (CAPSULE, [0.05, 0.4]),
    (CYLINDER, [0.25, 0.4]),
    (ELLIPSOID, [0.2, 0.2, 0.5]),
    (ELLIPSOID, [0.4, 0.4, 0.1]),
    (ELLIPSOID, [0.3, 0.3, 0.3]),
]


def _depth(a, R_WA, b, R_WB, p, tolerance=1e-9):
    pair = core_pair(*a, R_WA, *b, R_WB, p)
    u, move = revolution.common_axis(pair)
    size = pair.shape_A.sum() + pair.shape_B.sum() + np.linalg.norm(p)
    return revolution.depth_of_revolution(pair, u, move, size, tolerance), radius_of(pair)


@pytest.mark.parametrize('a', BODIES)
@pytest.mark.parametrize('b', BODIES)
def test_parallel_axes(a, b):
    rng = np.random.default_rng(6)
    for k in range(3):
        R = random_rotation(rng)
        p = R @ (np.array([0.05, 0.1, 0.2]) * rng.uniform(-1, 1, 3)) * (k < 2)
        phi, _ = signed_distance((a[0], a[1]), (R, [0, 0, 0]), (b[0], b[1]), (R, p))
        (upper, lower, n, a_, b_, *_), radius = _depth(a, R, b, R, p)
        if phi + radius >= 0:
            continue  # the cores are apart
        assert lower - 1e-12 <= -phi - radius <= upper + 1e-12
        assert upper - lower <= 1.1e-9
        assert np.subtract(a_, b_) == pytest.approx(upper * np.array(n), abs=1e-14)


def test_parallel_cylinders_touch_where_they_are_side_by_side():
    tall, low = (CYLINDER, [0.25, 1.0]), (CYLINDER, [0.3, 0.1])
    (upper, lower, n, a, b, _, unique), _ = _depth(tall, ALIGNED, low, ALIGNED, (0.5, 0.0, 0.8))
    assert upper == pytest.approx(0.05, abs=1e-15)
    assert lower == pytest.approx(0.05, abs=1e-15)
    assert n == pytest.approx((1, 0, 0), abs=1e-15)
    assert unique
    assert a[2] == pytest.approx(b[2], abs=1e-15)
    assert 0.7 <= a[2] <= 0.9
    assert a[:2] == pytest.approx((0.25, 0.0), abs=1e-15)
    assert b[:2] == pytest.approx((0.2, 0.0), abs=1e-15)


def test_a_ring_of_answers_points_along_x_of_B():
    R = random_rotation(np.random.default_rng(7))
    body = (CYLINDER, [0.25, 1.0])
    (upper, _, n, *_, unique), _ = _depth(body, R, body, R, (0.0, 0.0, 0.0))
    assert upper == pytest.approx(0.5, abs=1e-15)
    assert n == pytest.approx(-R[:, 0], abs=1e-14)
    assert not unique


@pytest.mark.parametrize('angle', [1e-15, 1e-12, 1e-10])
def test_almost_parallel_axes_pay_with_the_lower_bound(angle):
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    body = (CYLINDER, [0.25, 1.0])
    (upper, lower, *_), _ = _depth(body, ALIGNED, body, R, (0.0, 0.0, 0.0))
    assert lower - 1e-15 <= 0.5 <= upper + 1e-15
    assert angle / 2 <= upper - lower + 1e-14 <= 8 * angle + 1e-13


def test_a_box_and_an_ellipsoid_of_three_axes_have_no_axis():
    assert revolution.axis_of_revolution(BOX, np.array([1.0, 1.0, 2.0]))[1] == np.inf
    assert revolution.axis_of_revolution(ELLIPSOID, np.array([1.0, 2.0, 4.0])) == (2, 1.0)
    assert revolution.axis_of_revolution(ELLIPSOID, np.array([1.0, 2.0, 2.0])) == (0, 0.0)
    assert revolution.axis_of_revolution(ELLIPSOID, np.array([2.0, 1.0, 2.0])) == (1, 0.0)
