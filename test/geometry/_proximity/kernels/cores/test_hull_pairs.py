"""Hulls beside round bodies of any size: as narrow as promised, proven by planes, witnesses on."""

import numpy as np
import pytest
from numba import config
from oracles.core_pairs import answer_of, circle, core_pair, widths
from oracles.forms import hull_of
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    NORMAL,
)
from drake_geom_ros.geometry._proximity.kernels.cores import gjk, sums
from drake_geom_ros.geometry._proximity.kernels.revolution import rings
from drake_geom_ros.geometry._proximity.kernels.shapes import hulls
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import bounding_radius
from drake_geom_ros.geometry._proximity.kinds import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
)
from truth.bodies.random_bodies import random_directions, random_rotation

COUNT = 4 if config.DISABLE_JIT else 150
KINDS = [BOX, CAPSULE, CYLINDER, ELLIPSOID]


def _hull(rng, scale):
    stretch = scale * 10 ** rng.uniform(-1.5, 0, 3)
    points = random_directions(rng, rng.integers(4, 13)) * stretch
    return points, hull_of(points)


def _rotation(rng):
    return Rotation.random(random_state=rng.integers(1 << 31)).as_matrix()


@pytest.mark.parametrize('kind', KINDS)
@pytest.mark.parametrize('hinted', [False, True])
def test_bounds_are_as_narrow_as_promised_at_any_ratio_of_sizes(kind, hinted):
    rng = np.random.default_rng([7, kind])
    for _ in range(COUNT):
        _, hull = _hull(rng, 10 ** rng.uniform(-8, 4))
        size = 10 ** rng.uniform(-1.3, 0, 3)[: 3 if kind in (BOX, ELLIPSOID) else 2]
        radii = bounding_radius(kind, size), bounding_radius(CONVEX, hull)
        reach = rng.choice([0.3 * max(radii), sum(radii) * rng.uniform(0.3, 1.2), 3 * sum(radii)])
        p = reach * random_directions(rng, 1)[0]
        pair = core_pair(kind, size, _rotation(rng), CONVEX, hull, _rotation(rng), p)
        out, promised = answer_of(pair, random_directions(rng, 1)[0] if hinted else np.zeros(3))
        assert out[ERROR_BOUND] <= promised
        if out[DISTANCE] < 0.0:
            ns = np.vstack([random_directions(rng, 500), -out[NORMAL : NORMAL + 3]])
            near = ns[-1] + random_directions(rng, 100) * 10 ** rng.uniform(-7, -1, (100, 1))
            ns = np.vstack([ns, near])
            ns /= np.linalg.norm(ns, axis=1)[:, None]
            least = widths(pair, ns).min()
            assert least >= -out[DISTANCE] - out[ERROR_BOUND]
            assert least <= -out[DISTANCE] + out[ERROR_BOUND]


def test_a_speck_beside_a_capsule_is_apart_whatever_the_hint():
    """Their difference is a segment to rounding, and its faces are slivers without a side."""
    rng = np.random.default_rng(3)
    vertices = 1e-15 * rng.normal(size=(8, 3))
    hull = hull_of(vertices)
    size, R = np.array([2500.0, 1600.0]), _rotation(rng)
    p = R @ [0.0, 3000.0, 1500.0]
    pair = core_pair(CAPSULE, size, R, CONVEX, hull, _rotation(rng), p)
    for hint in random_directions(rng, 4 * COUNT):
        out, _ = answer_of(pair, hint)
        assert out[DISTANCE] == pytest.approx(500.0, abs=out[ERROR_BOUND] + 1e-11)


def test_the_edge_next_to_a_direction_falls_away_least():
    rng = np.random.default_rng(0)
    for _ in range(COUNT):
        vertices, shape = _hull(rng, 1.0)
        n = random_directions(rng, 1)[0]
        here, there = map(np.array, hulls.farthest_edge(shape, *n))
        assert here @ n == pytest.approx((vertices @ n).max(), abs=1e-15)
        others = vertices[(vertices != here).any(axis=1)] - here
        slopes = -(others @ n) / np.linalg.norm(others, axis=1)
        along = there - here
        assert -(along @ n) / np.linalg.norm(along) == pytest.approx(slopes.min(), abs=1e-12)


@pytest.mark.parametrize('kind', [*KINDS, CONVEX])
def test_the_difference_of_edges_is_below_that_of_the_hulls_and_as_much_along_the_normal(kind):
    rng = np.random.default_rng([3, kind])
    for _ in range(10):
        size = _hull(rng, 1.0)[1] if kind == CONVEX else rng.uniform(0.1, 1.0, 3)
        pair = (kind, size, _rotation(rng), CONVEX, _hull(rng, 1.0)[1], _rotation(rng))
        pair = core_pair(*pair, rng.normal(size=3))
        ns = [tuple(n) for n in random_directions(rng, 50)]
        terms, _, last, r_A, r_B = difference = sums.difference_of_edges(pair, ns[0])
        assert (terms[sums.SEGMENT : last, sums.LENGTH] > 0.0).all()
        for n in ns:
            a, b = gjk.support_points(pair, n, 0.0)
            width = sums.width(terms, last, r_A + r_B, n)
            assert width <= np.dot(np.subtract(a, b), n) + 1e-14
        a, b = gjk.support_points(pair, ns[0], 0.0)
        width = sums.width(terms, last, r_A + r_B, ns[0])
        assert width == pytest.approx(np.dot(np.subtract(a, b), ns[0]), abs=1e-14)
        for k in range(sums.SEGMENT, last):
            terms[k, sums.SHARE] = np.sign(np.dot(terms[k, :3], ns[0]))
        foot_a, foot_b = sums.witness_points(difference, ns[0])
        assert foot_a == pytest.approx(a, abs=1e-14)
        assert foot_b == pytest.approx(b, abs=1e-14)


@pytest.mark.parametrize('ratio', [0.5, 1.0, 2.0])
@pytest.mark.parametrize('scale', [1e-8, 1e-3, 0.02])
def test_a_hull_in_a_cylinder_that_is_large_beside_it(ratio, scale):
    rng = np.random.default_rng(5)
    for _ in range(COUNT // 4 + 1):
        _, hull = _hull(rng, scale)
        size = np.array([0.3, 0.3 * ratio])
        p = tuple(rng.choice([0.0, 1e-12, scale]) * rng.normal(size=3))
        pair = core_pair(CYLINDER, size, _rotation(rng), CONVEX, hull, _rotation(rng), p)
        complete, h, floor, n, unique = rings.least_of_hull_in_barrel(pair, 1e-15, 1e-16)
        assert complete
        assert h - 2e-15 <= floor <= h
        u = pair.R_WA[:, 2]
        turns = rng.uniform(0, 2 * np.pi, 3000)
        ring = circle(*pair.R_WA.T[:2], turns)
        ns = np.vstack([random_directions(rng, 2000), ring, [u, -u, n]])
        there = widths(pair, ns)
        assert there[-1] == pytest.approx(h, abs=1e-15)
        assert there.min() >= floor - 1e-15
        if unique:
            assert (there[ns @ np.array(n) < 0.98] > h + 1e-15).all()


def test_a_tiny_hull_at_the_axis_of_a_capsule():
    """As narrow as promised, and as deep as it is out across the axis, seen from all around."""
    rng, angles = np.random.default_rng(5), np.linspace(0, 2 * np.pi, 20_001)
    for _ in range(COUNT):
        scale = 10 ** rng.uniform(-7, -2)
        _, hull = _hull(rng, scale)
        R_WA = _rotation(rng)
        p = 0.2 * scale * rng.normal() * R_WA[:, 0] + rng.uniform(-0.4, 0.4) * R_WA[:, 2]
        pair = core_pair(CAPSULE, [0.2, 0.9], R_WA, CONVEX, hull, _rotation(rng), p)
        out, promised = answer_of(pair)
        assert out[ERROR_BOUND] <= promised
        truth = widths(pair, circle(R_WA[:, 0], R_WA[:, 1], angles)).min()
        if truth > 0.2:  # the axis goes through it
            assert truth - 1e-3 * scale <= -out[DISTANCE] <= truth + promised


@pytest.mark.parametrize('seed', [2, 3, 5, 6, 7])
def test_the_points_of_a_tiny_hull_at_the_axis_have_their_digits(seed):
    """EPA tells them by the weights of a sliver: that alone took three times what is promised."""
    rng = np.random.default_rng(seed)
    for _ in range(250):
        scale = 10 ** rng.uniform(-7, -2)
        _, hull = _hull(rng, scale)
        R_WA = random_rotation(rng)
        p = 0.2 * scale * rng.normal() * R_WA[:, 0] + rng.uniform(-0.4, 0.4) * R_WA[:, 2]
        pair = core_pair(CAPSULE, [0.2, 0.9], R_WA, CONVEX, hull, random_rotation(rng), p)
        out, promised = answer_of(pair)
        assert out[ERROR_BOUND] <= promised


def test_a_tiny_hull_just_beside_the_axis_of_a_capsule():
    """GJK's simplex is a sliver there: bounds were up to a million times as wide as promised."""
    rng = np.random.default_rng(11)
    for _ in range(8 * COUNT):
        scale = 10 ** rng.uniform(-7, -2)
        vertices, hull = _hull(rng, scale)
        R_WA, R_WB = _rotation(rng), _rotation(rng)
        gap = scale * 10 ** rng.uniform(-6, 0)
        across, along = R_WA[:, 0], rng.uniform(-0.4, 0.4) * R_WA[:, 2]
        p = (gap - (vertices @ R_WB.T @ across).min()) * across + along
        size = np.array([0.2, 0.9])
        pair = core_pair(CAPSULE, size, R_WA, CONVEX, hull, R_WB, p)
        out, promised = answer_of(pair)
        assert out[ERROR_BOUND] <= promised
        assert -out[DISTANCE] <= 0.2 - gap + out[ERROR_BOUND]


@pytest.mark.parametrize('kind', [CAPSULE, CYLINDER])
def test_a_needle_along_the_axis_from_far_along_it(kind):
    """Hunted: seen along the axis two of its ends are so near that no cut is across the axis."""
    rng, corners = np.random.default_rng(9), [[-1, 1, 1], [1, -1, -1], [-1, -1, 1], [1, -1, 1]]
    for _ in range(COUNT):
        thin = 10 ** rng.uniform(-8, -5)
        shape = np.array([thin, thin, 0.4])
        vertices = shape * (corners + rng.uniform(-1e-4, 1e-4, (4, 3)))
        R_WA = _rotation(rng)
        turn = Rotation.from_rotvec(10 ** rng.uniform(-12, -8) * rng.normal(size=3)).as_matrix()
        p = R_WA @ [*(1e-3 * thin * rng.normal(size=2)), rng.uniform(-3, 3)]
        hull = hull_of(vertices)
        R_WB = np.ascontiguousarray(R_WA @ turn)
        pair = core_pair(kind, [0.003, 11.0], R_WA, CONVEX, hull, R_WB, p)
        out, _ = answer_of(pair)
        angles = np.linspace(0, 2 * np.pi, 4001)
        ns = circle(R_WA[:, 0], R_WA[:, 1], angles)
        ns = np.vstack([ns, -out[NORMAL : NORMAL + 3]])
        least = widths(pair, ns / np.linalg.norm(ns, axis=1)[:, None]).min()
        assert abs(least + out[DISTANCE]) <= out[ERROR_BOUND] + 1e-3 * thin


def test_a_hull_that_fills_a_cylinder_is_left_to_others():
    hull = np.concatenate(([8], np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).ravel() * 0.2))
    pair = core_pair(
        CYLINDER, np.array([0.3, 0.3]), np.eye(3), CONVEX, hull, np.eye(3), (0.0, 0.0, 0.0)
    )
    assert not rings.least_of_hull_in_barrel(pair, 1e-15, 1e-16)[0]


def test_the_points_of_hulls_are_hulls_of_themselves():
    """What this file draws are corners of their hulls, so that no vertex is hidden."""
    rng = np.random.default_rng(1)
    for _ in range(10):
        vertices, _ = _hull(rng, 1.0)
        assert len(ConvexHull(vertices).vertices) == len(vertices)
