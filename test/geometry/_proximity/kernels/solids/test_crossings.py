"""How two triangles meet, part by part, whatever corner they begin with."""

import itertools

import numpy as np
import pytest

from drake_geom_ros.geometry._proximity.kernels.solids import crossings
from drake_geom_ros.geometry._proximity.kernels.solids.crossings import APART, CROSSED, TOUCHING
from truth.bodies.random_bodies import random_rotation

FLAT = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])
NEAR = 1e-9


def _both(one, other):
    """Return the corners of two triangles in a row, as they stand in a solid's parameters."""
    return np.concatenate((np.ravel(one), np.ravel(other)))


@pytest.mark.parametrize('order', list(itertools.permutations(range(3))))
def test_the_bluntest_corner_is_opposite_the_longest_edge(order):
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [5, 0.1, 0]])[list(order)]
    assert order[crossings.bluntest_corner(corners.ravel(), 0)] == 1


@pytest.mark.parametrize('order', list(itertools.permutations(range(3))))
@pytest.mark.parametrize(
    ('at', 'touches'),
    [
        ((1.0, 1.0), True),
        ((2.0, 2.0), True),
        ((3.9, 0.0), True),
        ((0.0, 3.9), True),
        ((2.0, 2.1), False),
        ((-0.1, 1.0), False),
        ((4.1, 0.0), False),
    ],
)
@pytest.mark.parametrize('common', [True, False])
def test_a_corner_touches_a_triangle_that_it_is_on(order, at, touches, common):
    """The other two corners are far above; one may be a corner of both, which says nothing."""
    above = FLAT[0] if common else np.array([0.0, 0.0, 5.0])
    other = np.array([above, [*at, 0.5 * NEAR], [9.0, 9.0, 9.0]])[list(order)]
    for turn in itertools.permutations(range(3)):
        shape = _both(other, FLAT[list(turn)])
        assert crossings.corner_touches(shape, 0, 9, NEAR) == touches
        assert not crossings.corner_touches(shape, 0, 9, 0.25 * NEAR) or not touches


def test_a_needle_without_area_has_no_normal():
    needle = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    plane = crossings.plane_of(_both(needle, FLAT), 0, 9, 1e-12)
    assert plane.n == (0.0, 0.0, 0.0)
    assert plane.noise == 1e-12


@pytest.mark.parametrize(
    ('other', 'how'),
    [
        ([[1, 1, -1], [1, 1, 1], [2, 1, 1]], CROSSED),
        ([[1, 1, 0], [1, 1, 2], [2, 1, 1]], TOUCHING),  # a corner within
        ([[1, -1, 0], [1, 1, 0], [1, 0, 5]], TOUCHING),  # an edge in the plane
        ([[0, 0, 0], [4, 0, 0], [1, 1, 3]], APART),  # a common edge
        ([[0, 0, 0], [1, 1, 3], [2, 1, 3]], APART),  # a common corner
        ([[0, 0, 0], [1, 1, 0], [2, 1, 3]], TOUCHING),  # that, and another within
        ([[1, 1, 0], [2, 1, 0], [1, 2, 0]], CROSSED),  # in the plane, within
        ([[4, 4, 0], [4, 1, 0], [1, 4, 0]], APART),  # in the plane, beside it
        ([[1, 1, 1], [2, 1, 1], [1, 2, 2]], APART),
        ([[5, 5, -1], [5, 5, 1], [6, 5, 1]], APART),  # through the plane, beside it
        ([[-1, 5, -1], [5, -1, -1], [2, 2, 9]], TOUCHING),  # an edge of one in the other
    ],
)
def test_triangles_meet_alike_in_either_order_and_from_any_corner(other, how):
    R = random_rotation(np.random.default_rng(1))
    for turned in (np.eye(3), R):
        for turn in range(3):
            one = np.roll(FLAT, turn, axis=0) @ turned.T
            two = np.roll(np.array(other, dtype=float), -turn, axis=0) @ turned.T
            shape = _both(one, two)
            # Rounding may make of what lies in the plane something that goes through it.
            if turned is R and how == TOUCHING:
                assert crossings.meeting(shape, 0, 9, 1e-14) != APART
                continue
            if turned is R and how == APART and other[0] == [0, 0, 0]:
                continue
            assert crossings.meeting(shape, 0, 9, 1e-14) == how
            assert crossings.meeting(shape, 9, 0, 1e-14) == how
