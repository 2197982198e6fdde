"""Newton's method on a normal, and the caps around it, against dense directions."""

import numpy as np
import pytest
from numba import config
from oracles.core_pairs import core_pair, core_widths, random_core_pair, turned

from drake_geom_ros.geometry._proximity.kernels.cores import caps, normals, sums
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes import supports
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER, ELLIPSOID
from drake_geom_ros.geometry._proximity.tolerances import RIGHT_ANGLE
from truth.bodies.random_bodies import random_rotation

PAIRS = [(BOX, CYLINDER), (BOX, ELLIPSOID), (CAPSULE, ELLIPSOID), (CYLINDER, CYLINDER)]
PAIRS += [(CAPSULE, CYLINDER), (CYLINDER, ELLIPSOID), (ELLIPSOID, ELLIPSOID)]
COUNT = 4 if config.DISABLE_JIT else 40
NOISE = 1e-14


def _around(rng, n, angles):
    """Random directions at the given angles from n."""
    t = np.cross(n, rng.normal(size=(len(angles), 3)))
    t /= np.linalg.norm(t, axis=1)[:, None]
    return np.cos(angles)[:, None] * np.array(n) + np.sin(angles)[:, None] * t


def _minima(kinds, reach, seed):
    rng = np.random.default_rng(seed)
    for _ in range(COUNT):
        pair = random_core_pair(rng, kinds, (0.3, 1.0), reach)
        difference = sums.difference_of(pair)
        n = sums.likely_normal(difference, (1.0, 0.0, 0.0))
        found = normals.nearby_minimum(difference, n, NOISE)
        if found[0] != normals.NOTHING:
            yield rng, pair, difference, found


@pytest.mark.parametrize('kinds', PAIRS)
@pytest.mark.parametrize('reach', [0.2, 3.0])
def test_it_is_a_minimum_and_its_feet_are_on_its_normal(kinds, reach):
    found_any = False
    for rng, pair, difference, found in _minima(kinds, reach, 1):
        _, n, h, _ = found
        found_any = True
        a, b = sums.witness_points(difference, n)
        assert np.subtract(a, b) == pytest.approx(h * np.array(n), abs=1e-12)
        assert h == pytest.approx(core_widths(pair, n), abs=1e-14)
        near = _around(rng, n, 10 ** rng.uniform(-6, -3, 20))
        assert core_widths(pair, near).min() >= h - 1e-14
    assert found_any


@pytest.mark.parametrize('kinds', PAIRS)
def test_nothing_in_a_cap_is_nearer(kinds):
    widths = []
    for rng, pair, difference, found in _minima(kinds, 0.2, 2):
        _, n, h, _ = found
        cap = caps.widest_cap(difference, found, 1e-12)
        widths.append(cap)
        inside = _around(
            rng, n, cap * np.append(rng.uniform(0, 1, 40) ** 2, np.linspace(0, 1, 40))
        )
        assert core_widths(pair, inside).min() >= h - 1e-14
    assert max(widths) >= 0.05


def test_kinds_of_minima():
    kinds = normals.NOTHING, normals.SMOOTH, normals.CREASE, normals.FLAT
    assert len(set(kinds)) == 4
    rod, cube = np.array([0.1, 1.0]), np.array([0.5, 0.5, 0.5])
    start = (0.9, 0.3, 0.1)
    start = tuple(np.array(start) / np.linalg.norm(start))
    for p, kind, margin in (
        ((0.55, 0.1, 0.2), normals.FLAT, 0.4),
        ((0.55, 0.55, 0.2), normals.CREASE, None),
    ):
        pair = CorePair(BOX, cube, np.eye(3), CYLINDER, rod, np.eye(3), p)
        difference = sums.difference_of(pair)
        near = sums.likely_normal(difference, start)
        found = normals.nearby_minimum(difference, near, NOISE)
        assert found[0] == kind
        if margin is not None:
            assert found[3] == pytest.approx(margin, abs=1e-14)
    ball = np.array([0.2, 0.3, 0.4])
    pair = CorePair(ELLIPSOID, ball, np.eye(3), CAPSULE, rod, np.eye(3), (1.0, 1.0, 0.5))
    assert normals.nearby_minimum(sums.difference_of(pair), start, NOISE)[0] == normals.CREASE
    pair = CorePair(*pair[:6], (1.0, 1.0, 2.0))
    assert normals.nearby_minimum(sums.difference_of(pair), start, NOISE)[0] == normals.SMOOTH


def test_what_an_earlier_search_leaned_on_is_forgotten():
    ball = np.array([0.2, 0.3, 0.4])
    pair = CorePair(ELLIPSOID, ball, np.eye(3), ELLIPSOID, ball, np.eye(3), (0.5, 0.25, 0.125))
    difference = sums.difference_of(pair)
    difference[0][[sums.LEAN_A, sums.LEAN_B], :3] = [[0.1, 0.2, 0.3], [0.3, 0.1, 0.2]]
    kind, n, h, _ = normals.nearby_minimum(difference, (0.8, 0.6, 0.0), NOISE)
    assert kind == normals.SMOOTH
    a, b = sums.witness_points(difference, n)
    assert np.subtract(a, b) == pytest.approx(h * np.array(n), abs=1e-12)


@pytest.mark.parametrize(
    ('size', 'axis', 'kind'),
    [
        ((0.3, 0.2, 0.4), 1, normals.SMOOTH),
        ((0.3, 0.2, 0.4), 0, normals.NOTHING),  # a saddle, and so the next two
        ((0.3, 0.4, 0.2), 0, normals.NOTHING),
        ((0.2, 0.3, 0.4), 1, normals.NOTHING),
        ((0.3, 0.2, 0.4), 2, normals.NOTHING),  # a maximum
    ],
)
def test_a_slope_of_zero_is_no_minimum_yet(size, axis, kind):
    """The width of two equal ellipsoids, one in the other, is least along the shortest axis."""
    pair = core_pair(ELLIPSOID, size, np.eye(3), ELLIPSOID, size, np.eye(3), np.zeros(3))
    found = normals.nearby_minimum(sums.difference_of(pair), tuple(np.eye(3)[axis]), NOISE)
    assert found[0] == kind


def test_two_needles_that_cross_have_no_cap():
    """Every normal around the common perpendicular but two is worse, but only just."""
    needle = np.array([0.2, 0.2, 0.2 + 2.0**-40])
    pair = CorePair(ELLIPSOID, needle, np.eye(3), ELLIPSOID, needle, np.eye(3), (0.0, 0.0, 0.0))
    difference = sums.difference_of(pair)
    found = normals.nearby_minimum(difference, (1.0, 0.0, 0.0), NOISE)
    assert caps.widest_cap(difference, found, 1e-9) == 0.0


@pytest.mark.parametrize('start', [(0.96, 0.28, 0.0), (0.96, -0.2, 0.2), (0.98, 0.12, -0.16)])
def test_from_beside_the_face_that_is_the_way_out_the_face_is_found(start):
    """Deep in one another h is concave beside a face's normal: down its slope, to the face."""
    cube, rod = np.array([0.5, 0.5, 0.5]), np.array([0.1, 0.2])
    pair = core_pair(BOX, cube, np.eye(3), CYLINDER, rod, np.eye(3), (0.4, 0.1, 0.05))
    near = tuple(np.array(start) / np.linalg.norm(start))
    found = normals.nearby_minimum(sums.difference_of(pair), near, NOISE)
    assert found.kind == normals.FLAT
    assert found.n == pytest.approx((1.0, 0.0, 0.0), abs=1e-15)
    assert found.h == pytest.approx(0.5 + 0.1 - 0.4, abs=1e-15)


def test_hulls_have_no_minimum_of_this_kind():
    hull = np.array([4.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1])
    pair = CorePair(BOX, np.ones(3), np.eye(3), supports.CONVEX, hull, np.eye(3), (0.0, 0.0, 0.0))
    found = normals.nearby_minimum(sums.difference_of(pair), (1.0, 0.0, 0.0), NOISE)
    assert found[0] == normals.NOTHING


@pytest.mark.parametrize('swap', [False, True])
def test_the_flat_end_of_a_cylinder_is_found_from_beside_it(swap):
    """At the axis of the disk h has a tip, which no slope leads to; the edge of B sinks in."""
    wide, tilted = np.array([0.5, 0.5]), turned((1, 0, 0), 0.6)
    shapes = (CYLINDER, wide, np.eye(3)), (CYLINDER, np.array([0.1, 0.3]), tilted)
    p = np.array([0.05, 0.1, 0.6])
    pair = core_pair(*shapes[1], *shapes[0], -p) if swap else core_pair(*shapes[0], *shapes[1], p)
    up = (0.0, 0.0, -1.0 if swap else 1.0)
    depth = 0.5 + 0.3 * np.cos(0.6) + 0.1 * np.sin(0.6) - 0.6
    rng = np.random.default_rng(7)
    for start in _around(rng, up, rng.uniform(0.1, 0.6, 20)):
        found = normals.nearby_minimum(sums.difference_of(pair), tuple(start), NOISE)
        assert found.kind == normals.FLAT
        assert found.n == pytest.approx(up, abs=1e-15)
        assert found.h == pytest.approx(depth, abs=1e-15)


def test_segments_that_are_parallel_but_for_rounding_leave_a_normal():
    """By one test they make a face, by another, of the same angle, they do not."""
    rng = np.random.default_rng(3)
    found = []
    for tilt in RIGHT_ANGLE * rng.uniform(0.9, 1.1, 4000):
        R = random_rotation(rng)
        first = CYLINDER, rng.uniform(0.1, 1.0, 2), R @ turned((1, 0, 0), tilt)
        pair = core_pair(*first, CAPSULE, rng.uniform(0.1, 1.0, 2), R, np.zeros(3))
        across = tuple(R @ turned((0, 0, 1), rng.uniform(0.0, 6.0))[0])
        found.append(normals.nearby_minimum(sums.difference_of(pair), across, NOISE).n)
    assert np.linalg.norm(found, axis=1) == pytest.approx(1.0, abs=1e-15)


def test_where_an_edge_ends_exactly_at_the_nearest_point_the_normal_has_all_its_digits():
    """Steps away from the edge led back to it until none were left."""
    rng = np.random.default_rng(11)
    rod, radii = np.array([0.005, 0.005, 0.5]), np.array([0.3, 0.5, 0.2])
    across, corner = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0), rod
    h = -0.1 - supports.core_radius(ELLIPSOID, radii)
    for _ in range(COUNT):
        R_WA, R_AB = random_rotation(rng), random_rotation(rng)
        foot = radii**2 * (R_AB.T @ -across)  # of the ellipsoid, along its inward normal
        foot /= np.linalg.norm(foot / radii)
        p = R_WA @ (corner + 0.1 * across - R_AB @ foot)
        pair = core_pair(BOX, rod, R_WA, ELLIPSOID, radii, R_WA @ R_AB, p)
        n = R_WA @ across
        for start in _around(rng, n, 10 ** rng.uniform(-10, -8, 5)):
            found = normals.nearby_minimum(sums.difference_of(pair), tuple(start), NOISE)
            assert found.kind != normals.NOTHING
            assert found.n == pytest.approx(n, abs=1e-14)
            assert found.h == pytest.approx(h, abs=1e-14)
