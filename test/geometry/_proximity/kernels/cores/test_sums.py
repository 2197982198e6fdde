"""The difference of two cores as a sum, against the support points of the cores."""

import numpy as np
import pytest
from oracles.core_pairs import random_core_pair

from drake_geom_ros.geometry._proximity.kernels.cores import gjk, sums
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes import supports
from truth.bodies.random_bodies import random_directions, random_rotation

KINDS = [supports.BOX, supports.CAPSULE, supports.CYLINDER, supports.ELLIPSOID]
PAIRS = [(a, b) for a in KINDS for b in KINDS if (a, b) != (supports.BOX, supports.BOX)]


@pytest.mark.parametrize('kinds', PAIRS)
def test_width_and_feet_are_those_of_the_support_points(kinds):
    rng = np.random.default_rng(1)
    for _ in range(10):
        pair, n = random_core_pair(rng, kinds), tuple(random_directions(rng, 1)[0])
        terms, first, last, r_A, r_B = difference = sums.difference_of(pair)
        a, b = gjk.support_points(pair, n, 0.0)
        for k in range(sums.SEGMENT, last):
            terms[k, sums.SHARE] = np.sign(np.dot(terms[k, :3], n))
        foot_a, foot_b = sums.witness_points(difference, n)
        assert first <= last <= sums.SEGMENT + sums.MOST_SEGMENTS
        assert foot_a == pytest.approx(a, abs=1e-14)
        assert foot_b == pytest.approx(b, abs=1e-14)
        width = sums.width(terms, last, r_A + r_B, n)
        assert width == pytest.approx(np.dot(np.subtract(a, b), n), abs=1e-14)


@pytest.mark.parametrize('kind', [supports.CYLINDER, supports.ELLIPSOID])
def test_bend_is_the_derivative(kind):
    rng = np.random.default_rng(2)
    for _ in range(10):
        pair = random_core_pair(rng, (kind, supports.CAPSULE))
        terms = sums.difference_of(pair)[0]
        e, f, n = random_rotation(rng)
        y, slope_e, slope_f, m_ee, m_ef, m_ff = sums.curvature(terms, sums.AXES_A, n, e, f)
        E, step = terms[sums.AXES_A : sums.AXES_B, :3], 1e-4

        def stretch(s, t, E=E, e=e, f=f, n=n):
            return np.linalg.norm(E @ (n + s * e + t * f))

        assert y == pytest.approx(stretch(0, 0), rel=1e-14)
        up, down = stretch(step, 0), stretch(-step, 0)
        assert slope_e == pytest.approx((up - down) / (2 * step), abs=1e-6)
        # Off the sphere, where |E n| is linear along n, its second derivative is the radius.
        assert m_ee == pytest.approx((up + down - 2 * y) / step**2, abs=1e-4)
        up, down = stretch(0, step), stretch(0, -step)
        assert slope_f == pytest.approx((up - down) / (2 * step), abs=1e-6)
        assert m_ff == pytest.approx((up + down - 2 * y) / step**2, abs=1e-4)
        mixed = stretch(step, step) - stretch(step, -step) - stretch(-step, step)
        mixed = (mixed + stretch(-step, -step)) / (4 * step**2)
        assert m_ef == pytest.approx(mixed, abs=1e-4)


def test_a_disk_has_no_derivative_at_its_axis():
    pair = supports.CYLINDER, np.array([0.5, 1.0]), np.eye(3), supports.CAPSULE
    pair = CorePair(*pair, np.array([0.1, 0.2]), np.eye(3), (1.0, 0.0, 0.0))
    terms = sums.difference_of(pair)[0]
    assert set(sums.curvature(terms, sums.AXES_A, (0.0, 0, 1), (1.0, 0, 0), (0.0, 1, 0))) == {0.0}
    assert tuple(sums.ellipsoid_support(terms, sums.AXES_A, (0.0, 0.0, 1.0))) == (0.0, 0.0, 0.0)


def test_likely_normals_are_those_of_faces_and_crossed_edges():
    cube, rod = np.array([0.5, 0.5, 0.5]), np.array([0.1, 1.0])
    pair = CorePair(
        supports.BOX, cube, np.eye(3), supports.CYLINDER, rod, np.eye(3), (0.58, 0.1, 0.0)
    )
    n = sums.likely_normal(sums.difference_of(pair), (0.0, 0.0, 1.0))
    assert tuple(n) == pytest.approx((1, 0, 0), abs=1e-15)
    pair = CorePair(*pair[:6], (0.1, 0.0, -1.45))
    n = sums.likely_normal(sums.difference_of(pair), (1.0, 0.0, 0.0))
    assert tuple(n) == pytest.approx((0, 0, -1), abs=1e-15)


def test_a_hull_has_no_such_sum():
    hull = np.array([4.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1])
    pair = CorePair(
        supports.BOX, np.ones(3), np.eye(3), supports.CONVEX, hull, np.eye(3), (0.0,) * 3
    )
    assert sums.difference_of(pair)[2] == 0


def test_common_points_are_seen():
    cube, rod = np.array([0.5, 0.5, 0.5]), np.array([0.1, 1.0])
    pair = CorePair(
        supports.BOX, cube, np.eye(3), supports.CYLINDER, rod, np.eye(3), (0.55, 0.0, 0.0)
    )
    assert sums.share_a_point(pair, (0.5, 0.0, 0.0), (0.45, 0.0, 0.0))
    assert sums.share_a_point(pair, (0.4, 0.0, 0.0), (0.65, 0.0, 0.0))
    apart = CorePair(*pair[:6], (0.625, 0.0, 0.0))
    assert not sums.share_a_point(apart, (0.5, 0.0, 0.0), (0.525, 0.0, 0.0))


@pytest.mark.parametrize(
    ('kind', 'q', 'inside'),
    [
        (supports.CYLINDER, (0.2, 0.1, 0.9), True),
        (supports.CYLINDER, (0.2, 0.1, 1.1), False),
        (supports.CYLINDER, (0.2, 0.3, 0.1), False),
        (supports.CYLINDER, (0.0, 0.4, 0.1), False),
        (supports.CYLINDER, (0.4, 0.0, 0.1), False),
        (supports.BOX, (0.2, -0.9, 1.9), True),
        (supports.BOX, (0.4, 0.9, 0.1), False),
        (supports.BOX, (0.2, 1.1, 0.1), False),
        (supports.BOX, (0.2, 0.9, -2.1), False),
        (supports.CAPSULE, (0.0, 0.0, 0.0), False),  # a segment is no solid
    ],
)
def test_points_of_solid_cores(kind, q, inside):
    size = np.array([0.3, 1.0, 2.0])
    assert sums.is_point_of(kind, size, q) == inside
