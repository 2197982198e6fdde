"""Signs of determinants: those of fractions, wherever the places are."""

from fractions import Fraction

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.solids.signs import (
    exact_sign,
    side,
    turn,
    two_product,
    two_sum,
)

CASES = 2000
FAR = {
    'at the origin': (0.0, 0.0, 0.0),
    'in a map': (5e5, 4e6, 0.1),
    'anywhere': (0.3, -7.7, 1e-3),
}


def place(v, p):
    """The place of v moved by p, to the last bit."""
    sums = [two_sum(float(x), float(y)) for x, y in zip(v, p, strict=True)]
    return tuple(s for s, _ in sums) + tuple(e for _, e in sums)


def fractions_of(q):
    return [Fraction(q[k]) + Fraction(q[k + 3]) for k in range(3)]


def sign_of(x):
    return (x > 0) - (x < 0)


def determinant(*columns):
    u, v, w = columns
    return (
        u[0] * (v[1] * w[2] - v[2] * w[1])
        + u[1] * (v[2] * w[0] - v[0] * w[2])
        + u[2] * (v[0] * w[1] - v[1] * w[0])
    )


def places(rng, far, count):
    """Points of a lattice of 0.1, most of which are in a plane with others, or a hair off it."""
    hair = rng.choice([0.0, 0.0, 1e-17, 1e-12], (count, 3))
    return [place(v, far) for v in 0.1 * rng.integers(0, 4, (count, 3)) + hair]


@pytest.mark.parametrize('name', FAR)
def test_the_side_of_a_plane_is_that_of_fractions(name):
    rng, flat, told = np.random.default_rng(1), 0, set()
    for _ in range(CASES):
        points = places(rng, FAR[name], 4)
        a, b, c, d = map(fractions_of, points)
        columns = [[x - y for x, y in zip(q, a, strict=True)] for q in (b, c, d)]
        truth = sign_of(determinant(*columns))
        assert side(*points, 0.0) == truth == exact_sign(*points, -1)
        flat += truth == 0
        told.add(truth)
    assert told == {-1, 0, 1}
    assert flat > 20


@pytest.mark.parametrize('axis', [0, 1, 2])
def test_a_turn_in_a_plane_is_that_of_fractions(axis):
    rng, told = np.random.default_rng(2), set()
    i, j = (axis + 1) % 3, (axis + 2) % 3
    for name in FAR:
        for _ in range(CASES // 4):
            points = places(rng, FAR[name], 3)
            a, b, c = map(fractions_of, points)
            truth = sign_of((b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]))
            assert turn(*points, axis, 0.0) == truth
            told.add(truth)
    assert told == {-1, 0, 1}


def test_what_places_may_be_off_counts_as_nothing():
    a, b, c = (place(v, (0.0, 0.0, 0.0)) for v in ((0, 0, 0), (1, 0, 0), (0, 1, 0)))
    for height, off, told in ((1e-12, 0.0, 1), (1e-12, 1e-12, 0), (1e-9, 1e-12, 1)):
        assert side(a, b, c, place((0.2, 0.3, height), (0.0, 0.0, 0.0)), off) == told
        beyond = place((0.5, -height, 0.0), (0.0, 0.0, 0.0))
        assert turn(a, b, beyond, 2, off) == -told


def test_sums_and_products_lose_nothing():
    rng = np.random.default_rng(3)
    for _ in range(CASES):
        x, y = (float(v) for v in rng.normal(size=2) * 10.0 ** rng.integers(-20, 20, 2))
        s, e = two_sum(x, y)
        assert Fraction(s) + Fraction(e) == Fraction(x) + Fraction(y)
        p, e = two_product(x, y)
        assert Fraction(p) + Fraction(e) == Fraction(x) * Fraction(y)
        assert p == x * y
