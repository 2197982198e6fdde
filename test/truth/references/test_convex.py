"""The truth against distances that need no oracle, and against 50 digits."""

import numpy as np
import pytest
from mpmath import mp, mpf
from oracles import body_truth, closed_forms
from oracles.forms import body
from oracles.pairs import random_pairs

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.cross_check.surfaces import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
)
from truth.bodies.random_bodies import (
    box_corners,
    random_directions,
    random_rotation,
)
from truth.references.convex import signed_distance
from truth.references.supports import DIGITS, MinkowskiDifference, posed


@pytest.mark.parametrize(
    ('a', 'b', 'p', 'expected'),
    [
        ((SPHERE, [1]), (SPHERE, [2]), (3, 4, 0), 2),
        ((SPHERE, [1]), (SPHERE, [2]), (0, 0, 0), -3),
        ((SPHERE, [0]), (BOX, [1, 2, 3]), (0, 0, 0), -1),
        ((BOX, [0.5] * 3), (BOX, [0.5] * 3), (0, 4, 0), 3),
        ((BOX, [0.5] * 3), (BOX, [0.5] * 3), (2, 2, 2), 3**0.5),
        ((BOX, [0.5] * 3), (CYLINDER, [0.25, 0.5]), (0, 0, 0.9), -0.1),
        ((CAPSULE, [0.1, 0.5]), (CAPSULE, [0.2, 0.5]), (0.5, 0, 0.3), 0.2),
        ((CAPSULE, [0.1, 0.5]), (CAPSULE, [0.1, 0.5]), (0, 0, 0), -0.2),
        ((CYLINDER, [0.25, 0.5]), (CYLINDER, [0.25, 0.5]), (0, 0, 0), -0.5),
        ((CYLINDER, [1, 1]), (CYLINDER, [1, 1]), (5, 0, 6), 5),
        ((ELLIPSOID, [1, 1, 1e-3]), (ELLIPSOID, [1, 1, 1e-3]), (0, 0, 0), -2e-3),
        ((ELLIPSOID, [0.3, 0.2, 0.1]), (SPHERE, [0.1]), (0.5, 0, 0), 0.1),
        ((ELLIPSOID, [0.3, 0.2, 0.1]), (HALF_SPACE, []), (0, 0, -0.05), -0.05),
    ],
)
def test_distances_known_by_hand(a, b, p, expected):
    R = random_rotation(np.random.default_rng(1))
    a, b = body(a, R), body(b, R, R @ np.array(p, dtype=float))
    phi, n = signed_distance(a, b)
    assert phi == pytest.approx(expected, abs=1e-14)
    assert np.linalg.norm(n) == pytest.approx(1, abs=1e-12)
    back, _ = signed_distance(b, a)
    assert back == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(
    'kinds',
    [
        (SPHERE, BOX), (SPHERE, CAPSULE), (SPHERE, CYLINDER), (SPHERE, ELLIPSOID), (BOX, BOX),
        (BOX, CAPSULE), (CAPSULE, CAPSULE), (BOX, HALF_SPACE), (ELLIPSOID, HALF_SPACE),
    ],
)  # fmt: skip
def test_it_agrees_with_fifty_digits(kinds):
    for pair in random_pairs(np.random.default_rng(3), kinds, 6):
        phi, _ = signed_distance(pair.a, pair.b)
        # R is orthogonal but for rounding, and the two take it differently.
        assert phi == pytest.approx(body_truth.signed_distance(pair.a, pair.b)[0], abs=1e-15)


def test_a_box_is_the_hull_of_its_corners():
    for pair in random_pairs(np.random.default_rng(2), (BOX, CYLINDER), 6):
        box, cylinder = pair.a, pair.b
        hull = Body('Convex', box_corners(box.size), box.R)
        of_hull, _ = signed_distance(hull, cylinder)
        assert signed_distance(box, cylinder)[0] == pytest.approx(of_hull, abs=1e-15)


def test_no_direction_is_better():
    rng = np.random.default_rng(4)
    directions = random_directions(rng, 100_000)
    for kinds in ((CYLINDER, CYLINDER), (BOX, ELLIPSOID), (CAPSULE, CYLINDER)):
        for pair in random_pairs(rng, kinds, 6):
            a, b = pair.a, pair.b
            phi, n = signed_distance(a, b)
            both = MinkowskiDifference(posed(a.form, *a.X_WG), posed(b.form, *b.X_WG))
            assert both.values(directions).max() <= phi + 1e-15
            assert both.values(n[None])[0] == pytest.approx(phi, abs=1e-12)


def test_a_direction_that_is_known_needs_no_search():
    a = body((BOX, [0.1, 0.2, 0.3]), random_rotation(np.random.default_rng(5)))
    b = body((ELLIPSOID, [0.1, 0.2, 0.1]), np.eye(3), np.array([0.5, 0.4, 0.3]))
    phi, n = signed_distance(a, b)
    again, _ = signed_distance(a, b, near=n)
    assert again == phi


def test_newtons_method_does_not_leap_over_the_maximum_beside_a_needle():
    """From 3e-10 rad beside it; alternate projections with 60 digits say 1.971370252870132065."""
    R = [0.813278321045404, -0.49050882881580077, -0.3130167110096855, 0.2841741598761591]
    R += [-0.13460853970705094, 0.9492763495930014, -0.5077631528343195, -0.8609771366834821]
    R = np.array([*R, 0.029915727169244604]).reshape(3, 3)
    p = np.array([0.5558668581744719, 1.7396846574949114, -0.7563712991490479])
    needle = (1.4339290658426254e-07, 1817.1667211231584, 7.976671784593878e-07)
    beside = np.array([0.3178771562761479, 0.8922829535918652, -0.3206013790475129])
    ball = Body('Sphere', (0.0001111274678975986,), np.eye(3), np.zeros(3))
    needle = Body('Ellipsoid', needle, R, p)
    phi, n = signed_distance(ball, needle, beside)
    found, _ = signed_distance(ball, needle)
    assert phi == pytest.approx(found, abs=1e-13)
    height = float(-np.linalg.norm(np.multiply(needle.size, R.T @ n)) + p @ n) - ball.size[0]
    assert phi == pytest.approx(height, abs=1e-12)
    assert phi - 1.971370252870132 == pytest.approx(0.0, abs=1e-7)


def test_the_offset_from_the_origin_costs_no_digit():
    shift = np.array([2.0**30, -(2.0**30), 2.0**30])
    p = np.array([0.5, 0.25, 0.125])
    box, ball = (BOX, [0.1] * 3), (SPHERE, [0.1])
    near, far = (
        signed_distance(body(box, np.eye(3), o), body(ball, np.eye(3), o + p))
        for o in (np.zeros(3), shift)
    )
    assert near[0] == far[0]


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
