"""Ways out of a solid, of which the shortest comes first."""

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids import overlap as solid_overlap
from drake_geom_ros.geometry._proximity.kernels.solids.clearing import cleared
from drake_geom_ros.geometry._proximity.kernels.solids.distance import NEVER, nearest
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, body_of, solid_of
from drake_geom_ros.geometry._proximity.kinds import SPHERE

TOLERANCE, SIZE = 1e-9, 8.0
LEFT = (-1.0, 0.0, 0.0)


def ways_out(radius, p):
    """Return the pushes (k, 4), direction and length [m], of a ball at p out of the L."""
    ball = np.array([radius])
    A, B = body_of(SPHERE, ball, np.eye(3)), solid_of(kernel_form(solid('L'))[1])
    pair = SolidPair(A, B, p, SIZE, TOLERANCE, radius)
    found = nearest(pair, (1.0, 0.0, 0.0), np.inf, NEVER)
    pushes = np.full((solid_overlap.MOST_PUSHES, 4), np.nan)
    count = solid_overlap.push_of(pair, found, pushes)
    return pushes[:count]


@pytest.mark.parametrize('gaps', [(0.1, 0.2), (0.2, 0.1), (0.15, 0.05), (0.05, 0.15)])
def test_a_ball_in_the_inner_corner_has_ways_out_by_both_walls_the_shorter_first(gaps):
    """The walls x = 1 and y = 1 of the notch, from x, y > 1: so far from them is the middle."""
    pushes = ways_out(0.3, (1.0 + gaps[0], 1.0 + gaps[1], 0.5))
    assert (np.diff(pushes[:, 3]) > 0.0).all()
    for wall in ([1.0, 0.0, 0.0, 0.3 - gaps[0]], [0.0, 1.0, 0.0, 0.3 - gaps[1]]):
        assert np.abs(pushes - wall).max(axis=1).min() <= 1e-12


@pytest.mark.parametrize(
    ('p', 'm', 'length'),
    [
        ((0.5, 0.25, 0.5), (0.0, -1.0, 0.0), 0.25),
        ((0.125, 0.5, 0.5), (-1.0, 0.0, 0.0), 0.125),
        ((1.5, 0.9375, 0.5), (0.0, 1.0, 0.0), 0.0625),
        ((0.5, 1.5, 0.875), (0.0, 0.0, 1.0), 0.125),
    ],
)
def test_a_ball_within_leaves_through_the_nearest_wall(p, m, length):
    (push,) = ways_out(0.03125, p)
    np.testing.assert_allclose(push, [*m, length + 0.03125], rtol=0, atol=1e-12)


def at(p, radius=0.1):
    """Return the ball and the L of a test, as they stand."""
    A = body_of(SPHERE, np.array([radius]), np.eye(3))
    B = solid_of(kernel_form(solid('L'))[1])
    return SolidPair(A, B, p, SIZE, TOLERANCE, radius)


@pytest.mark.parametrize('gaps', [(0.04, 0.3), (0.3, 0.06), (0.04, 0.06), (0.06, 0.04)])
def test_a_ball_escapes_by_one_push_after_another_until_it_touches_every_wall(gaps):
    """It stands that far from the walls of the notch, and ends a radius from those it was in."""
    start = (1e-6, 1e-6, 0.0)
    pair = at((1.0 + gaps[0], 1.0 + gaps[1], 0.5))
    expected = np.maximum(start, [0.1 - gaps[0], 0.1 - gaps[1], 0.0])
    for most, is_out in ((1.0, True), (0.03, False)):
        clear, t, _ = solid_overlap.escape(pair, start, most, solid_overlap.MOST_ROUNDS)
        assert clear == is_out
        assert not is_out or t == pytest.approx(expected, abs=1e-12)
        apart, _, _ = cleared(pair, t, LEFT)
        assert not clear or apart


@pytest.mark.parametrize('aside', [0.0, 0.05, 0.3])
def test_a_ball_that_is_out_slides_back_to_where_it_is_out_by_the_shortest_way(aside):
    pair = at((1.04, 1.5, 0.5))
    t = (0.2, aside, 0.1)
    clear, t, found = cleared(pair, t, LEFT)
    assert clear
    t, m, a, b = solid_overlap.slide(pair, t, found)
    assert t == pytest.approx((0.06, 0.0, 0.0), abs=1e-9)
    assert m == pytest.approx((1.0, 0.0, 0.0), abs=1e-9)  # out of the L
    assert a == pytest.approx((1.1, 1.5, 0.5), abs=1e-9)  # of its core
    assert b == pytest.approx((1.0, 1.5, 0.5), abs=1e-9)
