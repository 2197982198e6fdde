import numpy as np
import pytest
from oracles.core_pairs import core_pair
from oracles.forms import ALIGNED, hull_of, signed_distance

from drake_geom_ros.geometry._proximity.kernels import vectors
from drake_geom_ros.geometry._proximity.kernels.cores import gjk
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CONVEX, CYLINDER
from truth.bodies.random_bodies import random_rotation


def _walk(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p, tolerance=0.0, cutoff=np.inf):
    pair = core_pair(kind_A, shape_A, R_WA, kind_B, shape_B, R_WB, p)
    size = np.abs(pair.shape_A).max() + np.abs(pair.shape_B).max() + np.linalg.norm(p)
    n = tuple(np.array(p) / np.linalg.norm(p)) if np.any(p) else (1.0, 0.0, 0.0)
    return gjk.distance_of_cores(pair, n, size, tolerance, cutoff)


def _hull(rng, count):
    return hull_of(rng.normal(size=(count, 3)))


def test_aligned_cubes_are_three_apart():
    end, upper, lower, n, a, b, _ = _walk(
        BOX, [0.5] * 3, ALIGNED, BOX, [0.5] * 3, ALIGNED, (0, 4, 0)
    )
    assert (end, upper, lower) == (gjk.CLOSED, 3.0, 3.0)
    assert tuple(n) == (0.0, 1.0, 0.0)
    assert np.subtract(b, a) == pytest.approx([0, 3, 0], abs=0)


def test_polytopes_end_exactly():
    rng = np.random.default_rng(1)
    for _ in range(12):
        hulls = _hull(rng, 12), _hull(rng, 20)
        R, p = random_rotation(rng), 6.0 * rng.normal(size=3)
        phi, _ = signed_distance(
            (CONVEX, hulls[0]), (ALIGNED, [0, 0, 0]), (CONVEX, hulls[1]), (R, p)
        )
        if phi < 0.01:
            continue
        end, upper, lower, _, a, b, _ = _walk(CONVEX, hulls[0], ALIGNED, CONVEX, hulls[1], R, p)
        assert end == gjk.CLOSED
        assert upper - lower <= 1e-14 * (10 + np.linalg.norm(p))
        assert upper == pytest.approx(phi, abs=1e-11)
        assert np.linalg.norm(np.subtract(a, b)) == pytest.approx(upper, rel=1e-15)


@pytest.mark.parametrize('gap', [1e-15, 1e-12, 1e-9, 1e-3, 1.0, 1e6])
def test_bounds_hold_for_every_gap(gap):
    rng = np.random.default_rng(2)
    for _ in range(20):
        R, n = random_rotation(rng), rng.normal(size=3)
        n /= np.linalg.norm(n)
        shape_A, shape_B = np.array([0.3, 0.7]), np.array([0.2, 0.4, 0.1])
        none = (0.0, 0.0, 0.0)
        pair = CorePair(CYLINDER, shape_A, R, BOX, shape_B, ALIGNED, none)
        a, b = gjk.support_points(pair, tuple(n), 0.0)
        p = np.subtract(a, b) + gap * n
        _, upper, lower, *_ = _walk(CYLINDER, shape_A, R, BOX, shape_B, ALIGNED, p)
        noise = 1e-15 * (1 + gap)
        assert lower - noise <= gap <= upper + noise


def test_closed_tells_that_the_slab_along_the_gap_is_as_wide():
    rng = np.random.default_rng(3)
    ends = []
    for _ in range(60):
        R, p = random_rotation(rng), 4.0 * rng.normal(size=3)
        shapes = np.array([0.6, 0.9]), rng.uniform(0.2, 1.0, 3)
        pair = CorePair(CYLINDER, shapes[0], R, BOX, shapes[1], ALIGNED, tuple(p))
        n = tuple(p / np.linalg.norm(p))
        found = gjk.distance_of_cores(pair, n, 10.0, 1e-9, np.inf)
        end, upper, _, n, *_ = found
        a, b = gjk.support_points(pair, n, 0.0)
        ends.append(end)
        if end == gjk.CLOSED:
            assert np.dot(np.subtract(b, a), n) >= upper - 1e-9 - 1e-14
        a, b = gjk.support_points(pair, found.n_lower, 0.0)
        assert np.dot(np.subtract(b, a), found.n_lower) >= found.lower - 1e-14
    assert ends.count(gjk.CLOSED) > 30


def test_a_walk_that_is_cut_off_has_not_looked_along_its_gap(monkeypatch):
    """One step from a bad start: the simplex has moved on, and nobody has seen its slab."""
    monkeypatch.setattr(gjk, 'GJK_STEPS', 1)
    walk = getattr(gjk.distance_of_cores, 'py_func', gjk.distance_of_cores)
    shape, p = np.array([0.5, 0.5, 0.5]), (0.3, 4.0, 0.2)
    pair = CorePair(BOX, shape, ALIGNED, BOX, shape, ALIGNED, p)
    assert walk(pair, (0.8, 0.6, 0.0), 6.0, 0.0, np.inf).end == gjk.CLOSED_ASIDE


def test_overlap_is_told_with_the_origin_on_or_in_the_difference():
    for p in ((0, 0, 0), (0.9, 0, 0), (1.0, 0, 0)):
        end, upper, *_ = _walk(BOX, [0.5] * 3, ALIGNED, BOX, [0.5] * 3, ALIGNED, p)
        assert end == gjk.OVERLAP
        assert upper <= 1e-15


def test_beyond_the_cutoff_the_walk_ends_early_with_a_bound():
    end, upper, lower, *_ = _walk(
        CAPSULE, [0.1, 1], ALIGNED, CYLINDER, [1, 1], ALIGNED, (7, 3, 2), cutoff=2.0
    )
    assert end == gjk.BEYOND_CUTOFF
    assert 2.0 < lower <= upper


def _simplex(*corners):
    """Return rows of points w = a - b, with b ten times the corner."""
    points = np.full((4, gjk.WEIGHT + 1), np.nan)
    for k, corner in enumerate(corners):
        w = np.array(corner, dtype=float)
        gjk.put(points, k, tuple(11.0 * w), tuple(10.0 * w))
    return points


def test_a_row_holds_a_point_and_what_it_is_the_difference_of():
    points = _simplex((1, 2, 3))
    assert points[0, :9].tolist() == [1, 2, 3, 11, 22, 33, 10, 20, 30]
    assert [vectors.vector_in(points, 0, column) for column in (0, 3, 6)] == [
        (1.0, 2.0, 3.0),
        (11.0, 22.0, 33.0),
        (10.0, 20.0, 30.0),
    ]


def test_a_point_is_known_by_all_three_coordinates():
    points = _simplex((1, 2, 3), (4, 5, 6), (7, 8, 9))
    for w in ((1, 2, 3), (4, 5, 6)):
        assert gjk.is_in_simplex(points, 2, w)
        for k in range(3):
            assert not gjk.is_in_simplex(points, 2, (*w[:k], 0.5, *w[k + 1 :]))
    assert not gjk.is_in_simplex(points, 2, (7, 8, 9))


@pytest.mark.parametrize(
    ('corners', 'kept', 'nearest'),
    [
        ([(1, 1, 1)], [0], (1, 1, 1)),
        ([(-1, 1, 1), (3, 1, 1)], [0, 1], (0, 1, 1)),
        ([(1, 1, 1), (3, 1, 1)], [0], (1, 1, 1)),
        ([(3, 1, 1), (1, 1, 1)], [1], (1, 1, 1)),
        ([(-1, -1, 2), (2, -1, 2), (-1, 2, 2)], [0, 1, 2], (0, 0, 2)),
        ([(9, 9, 2), (-1, 1, 2), (1, 1, 2)], [1, 2], (0, 1, 2)),
        ([(1, 2, 2), (5, 9, 2), (9, 5, 2)], [0], (1, 2, 2)),
        ([(-1, -1, -1), (3, -1, -1), (-1, 3, -1), (-1, -1, 3)], [0, 1, 2, 3], (0, 0, 0)),
        ([(0, 0, 9), (-1, -1, 2), (2, -1, 2), (-1, 2, 2)], [1, 2, 3], (0, 0, 2)),
        ([(5, 5, 9), (1, 1, 2), (-1, 1, 2), (0, 5, 2)], [1, 2], (0, 1, 2)),
    ],
)
def test_a_simplex_keeps_the_corners_that_hold_its_nearest_point(corners, kept, nearest):
    points = _simplex(*corners)
    count = gjk.reduce_simplex(points, len(corners))
    assert points[:count, :3].tolist() == [list(map(float, corners[k])) for k in kept]
    assert points[:count, gjk.WEIGHT].sum() == pytest.approx(1.0, abs=1e-15)
    for column, factor in ((0, 1.0), (3, 11.0), (6, 10.0)):
        found = gjk.combine(points, count, column)
        assert found == pytest.approx(np.multiply(factor, nearest), abs=1e-14)
