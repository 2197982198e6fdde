"""The ways to a depth: which is gone for which pair, and what is made of what it leaves open."""

import numpy as np
import pytest
from oracles.core_pairs import core_pair
from oracles.forms import hull_of

from drake_geom_ros.geometry._proximity.kernels.convex import depths
from drake_geom_ros.geometry._proximity.kernels.cores import normals, sums
from drake_geom_ros.geometry._proximity.kernels.cores.records import (
    Depth,
    Least,
    Minimum,
    Touch,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER, ELLIPSOID

SIZES = {
    BOX: [0.5, 0.6, 0.7],
    CAPSULE: [0.1, 0.6],
    CYLINDER: [0.3, 0.8],
    ELLIPSOID: [0.3, 0.4, 0.5],
    CONVEX: [4.0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1],
}
TURNED = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
NO_MEMORY = np.zeros(0)
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def _pair(kind_A, kind_B, R_WB=TURNED, p=(0.3, 0.1, 0.05)):
    return core_pair(kind_A, SIZES[kind_A], np.eye(3), kind_B, SIZES[kind_B], R_WB, p)


def _python(function):
    """Return the function uncompiled, so that what it calls can be replaced."""
    return getattr(function, 'py_func', function)


@pytest.mark.parametrize(
    ('upper', 'lower', 'axes'),
    [(5.0, 0.1, True), (5.0, 5.0 - 5e-9, True), (5.0, 5.0 - 3e-9, False), (0.25, 0.1, False)],
)
@pytest.mark.parametrize('n', [X, Y])
def test_axes_are_tried_where_bounds_are_left_apart_and_taken_where_less(
    monkeypatch, upper, lower, axes, n
):
    """Out along x: half a box, the capsule's segment across it, less what they are apart."""
    pair = _pair(BOX, CAPSULE, np.eye(3), (0.1, 0.05, 0.0))
    found = Depth(upper, lower, n, (7.0, 0.0, 0.0), (2.0, 0.0, 0.0), 0.5, True)
    monkeypatch.setattr(depths, 'iterated_depth', lambda *_: found)
    difference = sums.difference_of(pair)
    depth = _python(depths.depth_and_bounds)(
        pair, difference, normals.nowhere(X), False, 2.0, 1e-9, NO_MEMORY
    )
    if not axes:
        assert depth == found
        return
    assert depth.upper == pytest.approx(0.4, abs=1e-15)
    assert depth.lower == pytest.approx(min(lower, 0.4), abs=1e-15)
    assert depth.n == X
    apart = np.subtract(depth.a, depth.b)
    assert np.dot(apart, X) == pytest.approx(0.4, abs=1e-15)
    assert depth.aside == pytest.approx(np.linalg.norm(apart - 0.4 * np.array(X)), abs=1e-15)
    assert depth.unique == (n == X)


@pytest.mark.parametrize(
    ('kind_A', 'kind_B', 'by_creases'),
    [
        (BOX, CYLINDER, True),
        (CAPSULE, CYLINDER, True),
        (CYLINDER, CYLINDER, False),  # two disks: a minimum may be on no crease
        (BOX, ELLIPSOID, False),
        (CAPSULE, ELLIPSOID, False),
    ],
)
def test_creases_are_asked_about_boxes_and_capsules_in_cylinders_only(
    monkeypatch, kind_A, kind_B, by_creases
):
    pair = _pair(kind_A, kind_B)
    nothing = Minimum(depths.NOTHING, X, 1.0, 0.0)
    least = Least(True, 0.25, 0.125, Z, False)
    epa = Depth(0.5, 0.5, Y, Y, Y, 0.0, True)
    a, b = (0.0, 0.0, 0.25), (0.0, 0.0, 0.0)
    for name, told in (
        ('nearby_minimum', nothing),
        ('least_on_creases', least),
        ('points_at', (Z, 0.25, a, b, 0.03125)),
        ('share_a_point', True),
        ('depth_of_cores', epa),
    ):
        monkeypatch.setattr(depths, name, lambda *_, told=told: told)
    depth = _python(depths.iterated_depth)(
        pair, sums.difference_of(pair), normals.nowhere(X), False, 2.0, 1e-9, NO_MEMORY
    )
    assert depth == (Depth(0.25, 0.125, Z, a, b, 0.03125, False) if by_creases else epa)


def test_points_are_sought_at_right_angles_to_each_segment(monkeypatch):
    """The direction was found on the crease of another segment, which is almost parallel."""
    pair = _pair(CAPSULE, CYLINDER, np.array([[1, 0, 0], [0, 0.8, -0.6], [0, 0.6, 0.8]]))
    difference = sums.difference_of(pair)
    e = np.array([0.0, -0.6, 0.8])
    n = np.array([1.0, 0.0, 1e-7])
    n /= np.linalg.norm(n)
    nothing = Minimum(depths.NOTHING, X, 1.0, 0.0)
    seen = []

    def settled(_, m, h, noise):
        seen.append(m)
        return X, Y, abs(np.dot(e, m)) + 1e-13

    monkeypatch.setattr(depths, 'nearby_minimum', lambda *_: nothing)
    monkeypatch.setattr(depths, 'settled', settled)
    terms, _, last, r_A, r_B = difference
    h = sums.width(terms, last, r_A + r_B, tuple(n))
    m, there, *_, aside = _python(depths.points_at)(difference, tuple(n), h, 1e-6, 1e-16)
    assert len(seen) == 3
    assert aside == pytest.approx(1e-13, abs=1e-15)
    assert abs(np.dot(e, m)) < 1e-16
    assert there == sums.width(terms, last, r_A + r_B, m)
    assert there <= h + 5e-7


@pytest.mark.parametrize(
    ('kind_A', 'kind_B', 'expected'),
    [
        (CYLINDER, CONVEX, ['hull']),
        (CAPSULE, CONVEX, ['hull']),
        (CYLINDER, ELLIPSOID, ['A', 'slices']),
        (CYLINDER, CYLINDER, ['A', 'B', 'both']),
        (CAPSULE, CYLINDER, ['A', 'B']),
        (BOX, CYLINDER, ['B']),
        (CAPSULE, ELLIPSOID, ['A', 'slices']),
        (ELLIPSOID, ELLIPSOID, ['slices']),
        (BOX, ELLIPSOID, []),  # a box has edges off the axis
    ],
)
def test_a_ring_is_asked_for_by_the_ways_of_its_pair_until_one_is_complete(
    monkeypatch, kind_A, kind_B, expected
):
    ways, last = [], 0

    def asked(way):
        ways.append(way)
        return Least(len(ways) == last, 0.25, 0.25, Z, True)

    def in_barrel(difference, k, axes, *_):
        rows = {sums.AXES_A: (sums.SEGMENT, 'A'), sums.AXES_B: (difference.first, 'B')}
        assert k == rows[axes][0]
        return asked(rows[axes][1])

    monkeypatch.setattr(depths, 'least_in_long_barrel', in_barrel)
    for name, way in (
        ('least_of_hull_in_barrel', 'hull'),
        ('least_of_barrels', 'both'),
        ('least_over_slices', 'slices'),
    ):
        monkeypatch.setattr(depths, name, lambda *_, way=way: asked(way))
    pair = _pair(kind_A, kind_B)
    difference = sums.difference_of(pair)
    search = _python(depths.least_of_ring)
    assert not search(pair, difference, X, 0.5, 0.125, 1e-9, 1e-15).complete
    assert ways == expected
    for last in range(1, len(expected) + 1):
        ways.clear()
        assert search(pair, difference, X, 0.5, 0.125, 1e-9, 1e-15).complete
        assert ways == expected[:last]


@pytest.mark.parametrize(('off', 'taken'), [(1e-13, True), (-1e-13, True), (1e-11, False)])
def test_points_follow_the_normal_that_newton_knows_of_the_same_depth(monkeypatch, off, taken):
    """Where h is almost level its least tells little of the normal, which moves the points."""
    difference, m = sums.difference_of(_pair(CAPSULE, ELLIPSOID)), (0.6, 0.0, 0.8)
    newton = Minimum(normals.SMOOTH, m, 1.0 + off, 0.0)
    monkeypatch.setattr(depths, 'nearby_minimum', lambda *_: newton)
    found = _python(depths.points_at)(difference, Z, 1.0, 1e-9, 1e-12)
    assert (found.n, found.h) == ((m, 1.0 + off) if taken else (Z, 1.0))
    a, b = sums.witness_points(difference, found.n)
    off_line = np.linalg.norm(np.subtract(a, b) - found.h * np.array(found.n))
    assert found.aside == pytest.approx(off_line, rel=1e-12)


@pytest.mark.parametrize(('there', 'taken'), [(1.0, True), (1.0 + 1e-11, False)])
def test_points_of_hulls_count_where_the_hulls_are_as_deep(monkeypatch, there, taken):
    """The edges next to a normal are in the hulls, which may reach beyond them elsewhere."""
    pair, zero = _pair(BOX, CONVEX), (0.0, 0.0, 0.0)
    touch = Touch(X, 0.5, X, zero, 0.0)
    monkeypatch.setattr(depths, 'points_at', lambda *_: touch)
    monkeypatch.setattr(depths, 'settled', lambda *_: (Y, Z, 0.125))
    monkeypatch.setattr(depths, 'support_points', lambda *_: ((there, 0.0, 0.0), zero))
    found = _python(depths.points_on_edges)(pair, Z, 1.0, 1e-9, 1e-12)
    assert found == (Touch(X, 1.0, X, zero, 0.0) if taken else Touch(Z, 1.0, Y, Z, 0.125))


def test_a_ring_that_contradicts_a_proven_depth_is_not_believed(monkeypatch):
    """A search may be wrong; EPA's polytope is in the difference, whatever that search says."""
    points = 1e-4 * np.random.default_rng(2).normal(size=(12, 3))
    hull = hull_of(points)
    pair = core_pair(CYLINDER, [0.3, 0.9], np.eye(3), CONVEX, hull, np.eye(3), (0.0, 0.0, 0.1))
    asked, difference = [], sums.difference_of(pair)

    def of_ring(*_):
        asked.append(1)
        return Least(True, -1.0, -1.0, Z, True)

    monkeypatch.setattr(depths, 'least_of_ring', of_ring)
    size = 1.5
    found = _python(depths.iterated_depth)(
        pair, difference, normals.nowhere(X), False, size, 1e-15, NO_MEMORY
    )
    assert asked
    assert found.upper == pytest.approx(0.3, abs=1e-3)
