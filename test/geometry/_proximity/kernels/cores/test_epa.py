import numpy as np
import pytest
from numba import config
from oracles.core_pairs import core_pair
from oracles.forms import ALIGNED, hull_of, signed_distance
from scipy.spatial import ConvexHull

from drake_geom_ros.geometry._proximity.kernels.cores import epa
from drake_geom_ros.geometry._proximity.kernels.cores.sums import difference_of
from drake_geom_ros.geometry._proximity.kernels.vectors import perpendicular
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    SPHERE,
)
from drake_geom_ros.geometry._proximity.tolerances import SLIVER
from truth.bodies.random_bodies import random_rotation

X = (1.0, 0.0, 0.0)


def _grow(kind_A, shape_A, kind_B, shape_B, R_WB, p, tolerance=1e-9, most_vertices=400, n=None):
    pair = core_pair(kind_A, shape_A, ALIGNED, kind_B, shape_B, R_WB, p)
    size = np.abs(pair.shape_A).sum() + np.abs(pair.shape_B).sum() + np.linalg.norm(p)
    return epa.depth_of_cores(
        *(pair, difference_of(pair), n or X, n is not None, size, tolerance, most_vertices)
    )


@pytest.mark.parametrize(
    ('p', 'depth', 'unique'),
    [
        ((0, 0, 0), 1.0, False),
        ((0.75, 0, 0), 0.25, True),
        ((0.75, 0.75, 0), 0.25, False),
        ((1, 0, 0), 0.0, True),
        ((1, 0.5, -0.25), 0.0, True),
    ],
)
def test_cubes_end_exactly_overlapping_or_touching(p, depth, unique):
    upper, lower, n, a, b, _, is_unique = _grow(BOX, [0.5] * 3, BOX, [0.5] * 3, ALIGNED, p)
    assert upper == pytest.approx(depth, abs=1e-15)
    assert lower == pytest.approx(depth, abs=1e-15)
    assert np.subtract(a, b) == pytest.approx(upper * np.array(n), abs=1e-15)
    assert np.abs(n).max() == pytest.approx(1, abs=1e-15)
    assert is_unique == unique


def test_hulls_end_exactly():
    rng = np.random.default_rng(3)
    for _ in range(6):
        hulls = [hull_of(rng.normal(size=(k, 3))) for k in (10, 16)]
        R, p = random_rotation(rng), 0.3 * rng.normal(size=3)
        phi, _ = signed_distance(
            (CONVEX, hulls[0]), (ALIGNED, [0, 0, 0]), (CONVEX, hulls[1]), (R, p)
        )
        upper, lower, n, *_, unique = _grow(
            CONVEX, hulls[0], CONVEX, hulls[1], R, p, tolerance=0.0
        )
        assert upper - lower <= 1e-13
        assert unique  # no face elsewhere is as near
        assert -phi == pytest.approx(upper, abs=1e-11)
        hint = np.add(n, 0.1 * rng.normal(size=3))
        hint = tuple(hint / np.linalg.norm(hint))
        again, *_ = _grow(CONVEX, hulls[0], CONVEX, hulls[1], R, p, tolerance=0.0, n=hint)
        assert again == pytest.approx(upper, abs=1e-13)


@pytest.mark.parametrize('most_vertices', [5, 8, 20, 60])
def test_bounds_hold_when_the_cap_ends_the_growth(most_vertices):
    rng = np.random.default_rng(4)
    for _ in range(6):
        R, p = random_rotation(rng), 0.2 * rng.normal(size=3)
        phi, _ = signed_distance(
            (CYLINDER, [0.4, 0.5]), (ALIGNED, [0, 0, 0]), (CYLINDER, [0.3, 0.6]), (R, p)
        )
        upper, lower, *_ = _grow(
            CYLINDER, [0.4, 0.5], CYLINDER, [0.3, 0.6], R, p, 0.0, most_vertices
        )
        assert -phi <= upper + 1e-12
        assert lower <= 0 or lower <= -phi + 1e-12
        if most_vertices == 60:
            assert upper - lower <= 1e-6


def test_a_tighter_tolerance_narrows_the_bounds():
    R = random_rotation(np.random.default_rng(5))
    gaps = []
    for tolerance in (1e-2, 1e-5, 1e-8):
        upper, lower, *_ = _grow(
            CYLINDER, [0.4, 0.5], CYLINDER, [0.3, 0.6], R, (0.3, 0.2, 0.1), tolerance
        )
        gaps.append(upper - lower)
        assert gaps[-1] <= tolerance
    assert gaps[2] < gaps[0]


def test_a_guess_of_overlap_ends_where_the_cores_are_apart():
    n = (0.6, 0.8, 0.0)
    upper, lower, *_ = _grow(BOX, [0.5] * 3, CYLINDER, [0.2, 0.3], ALIGNED, (2.0, 0.0, 0.0), n=n)
    assert lower <= upper < -0.1


def test_a_cap_is_left_where_a_face_may_be_nearer_beyond_it():
    n, m = (0.0, 0.0, 1.0), (0.0, np.sin(0.2), np.cos(0.2))
    assert not epa.is_in_cap(m, 0.9, n, 1.0, 0.0)
    assert not epa.is_in_cap(m, -0.1, n, 1.0, 0.8)
    # Nearer than 1 within acos(0.9) = 0.451 of m, which is 0.2 from n.
    assert epa.is_in_cap(m, 0.9, n, 1.0, 0.66)
    assert not epa.is_in_cap(m, 0.9, n, 1.0, 0.64)


@pytest.mark.parametrize('power', [2.0**-40, 1.0, 2.0**40])
@pytest.mark.parametrize(
    ('corners', 'flat'),
    [
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1e-14]], True),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, -1e-12]], False),
        ([[0, 0, 1e-14], [0.5, 0, 1], [0, 0.5, 1], [0, 0, 1]], False),
        ([[0, 0, 0], [1e-6, 0, 0], [0, 1e-6, 0], [1e-6, 1e-6, 1e-14]], True),
        ([[0, 0, 0], [1e-6, 0, 0], [0, 1e-6, 0], [1e-6, 1e-6, -1e-12]], False),
        ([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [0, 0, 1]], True),  # three in a row
        ([[1, 1, 1]] * 4, True),
    ],
)
def test_flat_is_a_height_that_rounding_makes_at_any_size(corners, flat, power):
    points = np.zeros((4, 9))
    points[:, :3] = power * np.array(corners)
    assert epa.is_flat(points, SLIVER, power) == flat


@pytest.mark.parametrize('tilt', [0.1, 0.5, 1.0])
def test_a_ring_is_three_directions_at_a_tilt_and_the_opposite_one(tilt):
    """The core of an ellipsoid (1, 1, 1/2) is that less a ball of 1/4 m: known point by point."""
    pair = core_pair(ELLIPSOID, [1.0, 1.0, 0.5], ALIGNED, SPHERE, [0.0], ALIGNED, np.zeros(3))
    points = np.zeros((4, 9))
    epa.ring_points(pair, (0.0, 0.0, 1.0), tilt, points)
    np.testing.assert_allclose(points[0, :3], [0, 0, -0.25], rtol=0, atol=1e-15)
    across, along = np.sin(tilt), np.cos(tilt)
    h = np.hypot(across, 0.5 * along)
    np.testing.assert_allclose(points[1:, 2], along * (0.25 / h - 0.25), rtol=1e-14)
    outwards = points[1:, :2] / (across * (1.0 / h - 0.25))
    np.testing.assert_allclose(outwards @ outwards.T, 1.5 * np.eye(3) - 0.5, rtol=0, atol=1e-14)


@pytest.mark.parametrize('seed', range(8))
def test_first_points_are_far_from_one_another_in_every_direction(seed):
    """The farther of two sides is at least half the width of A - B away."""
    rng = np.random.default_rng(seed)
    corners = [rng.normal(size=(4, 3)) * [1.0, 1.0, 10.0**-k] for k in (0, 3)]
    shapes = [hull_of(each) for each in corners]
    pair = core_pair(CONVEX, shapes[0], ALIGNED, CONVEX, shapes[1], ALIGNED, np.zeros(3))
    difference = (corners[0][:, None] - corners[1][None]).reshape(-1, 3)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    points = np.zeros((4, 9))
    points[0, :3] = difference[np.argmax(difference @ n)]
    epa.first_points(pair, tuple(n), points)
    p = points[:, :3]
    assert n @ p[1] == pytest.approx((difference @ n).min(), abs=1e-14)
    away = [perpendicular(tuple((p[1] - p[0]) / np.linalg.norm(p[1] - p[0])))]
    normal = np.cross(p[1] - p[0], p[2] - p[0])
    away.append(normal / np.linalg.norm(normal))
    for k, m in enumerate(away, start=2):
        assert abs(np.dot(p[k] - p[0], m)) >= 0.5 * np.ptp(difference @ m) - 1e-14
    np.testing.assert_allclose(p[1:], points[1:, 3:6] - points[1:, 6:9], rtol=0, atol=1e-15)


@pytest.mark.parametrize('seed', range(6))
def test_the_witnesses_of_overlapping_hulls_are_points_of_them(seed):
    rng = np.random.default_rng(seed)
    corners = [rng.normal(size=(k, 3)) for k in (8, 14)]
    shapes = [hull_of(each) for each in corners]
    R, p = random_rotation(rng), 0.3 * rng.normal(size=3)
    upper, _, n, a, b, aside, _ = _grow(CONVEX, shapes[0], CONVEX, shapes[1], R, p, tolerance=0.0)
    assert aside <= 1e-12
    assert np.subtract(a, b) == pytest.approx(upper * np.array(n), abs=1e-13)
    for points, witness in ((corners[0], np.array(a)), (corners[1], R.T @ (np.array(b) - p))):
        sides = ConvexHull(points).equations
        assert (sides[:, :3] @ witness + sides[:, 3]).max() == pytest.approx(0.0, abs=1e-12)


def _cylinders():
    R = random_rotation(np.random.default_rng(5))
    return core_pair(CYLINDER, [0.4, 0.5], ALIGNED, CYLINDER, [0.3, 0.6], R, (0.3, 0.2, 0.1))


@pytest.mark.skipif(not config.DISABLE_JIT, reason='compiled, it calls no replacement')
def test_a_polytope_that_folds_back_ends_the_growth_at_the_bound_before(monkeypatch):
    """Faces beyond the fold may be farther away than the one that rounding has drawn in."""
    pair, popped, pop = _cylinders(), [], epa.pop_living

    def pop_folded(faces, planes, heap, waiting):
        f, waiting = pop(faces, planes, heap, waiting)
        popped.append(float(planes[f, epa.OFFSET]))
        if len(popped) == 8:  # the bounds meet at the eleventh
            planes[f, epa.OFFSET] -= 0.01
        return f, waiting

    monkeypatch.setattr(epa, 'pop_living', pop_folded)
    monkeypatch.setattr(epa, 'is_in_cap', lambda *_: False)
    depth = epa.depth_of_cores(pair, difference_of(pair), X, False, 2.0, 1e-9, 60)
    assert len(popped) == 8
    assert 0.0 < depth.lower == max(popped[:7])


@pytest.mark.skipif(not config.DISABLE_JIT, reason='compiled, it calls no replacement')
def test_only_a_direction_that_is_better_or_closes_the_bounds_is_looked_at_closely(monkeypatch):
    rng, widths, bests, look = np.random.default_rng(11), [], [], epa.minimum_near

    def looked(pair, difference, n, width, *rest):
        known = look(pair, difference, n, width, *rest)
        widths.append(width)
        bests.append(known.width)
        return known

    monkeypatch.setattr(epa, 'minimum_near', looked)
    looks = 0
    for _ in range(12):
        widths.clear()
        bests.clear()
        R, p = random_rotation(rng), 0.2 * rng.normal(size=3)
        pair = core_pair(ELLIPSOID, [0.5, 0.3, 0.2], ALIGNED, ELLIPSOID, [0.4, 0.8, 0.1], R, p)
        depth = epa.depth_of_cores(pair, difference_of(pair), X, False, 2.0, 1e-9, 60)
        assert all(width < best for width, best in zip(widths[1:-1], bests, strict=False))
        assert len(widths) == 1 or widths[-1] <= min(bests[:-1]) + 1e-9
        assert depth.upper == min(bests)
        looks = max(looks, len(widths))
    assert looks >= 4
