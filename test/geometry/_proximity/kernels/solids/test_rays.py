"""Which places lie in a solid: by its cells, on its surface and a hair beside it."""

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids.rays import (
    INSIDE,
    OUTSIDE,
    PLACES,
    UNDECIDED,
    Posed,
    place_on,
    swaps_axes,
    where_is,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import tree_of
from drake_geom_ros.geometry._proximity.kinds import SOLID

TURNS = {
    'as it is': np.eye(3),
    'a quarter about z': np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    'axes in a ring': np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
}
MOVES = {'here': np.zeros(3), 'in a map': np.array([5e5, 4e6, 0.25])}


CELLS = [(0, 0), (1, 0), (0, 1)]


def is_between(c, x, dx, *, closed):
    """Whether x + dx is between c and c + 1, or on them."""
    if x in (c, c + 1) and dx == 0:
        return closed
    return c < x < c + 1 or (x == c and dx > 0) or (x == c + 1 and dx < 0)


@pytest.mark.parametrize('move', MOVES)
@pytest.mark.parametrize('turn', TURNS)
@pytest.mark.parametrize('cuts', [1, 3])
def test_places_beside_each_wall_to_the_last_bit(cuts, turn, move):
    """An L of cells of 1 m: points of a lattice, and some 2^-60 m beside them."""
    R, p = TURNS[turn], MOVES[move]
    shape = kernel_form(solid('L', cuts=cuts))[1]
    posed = Posed(shape, tree_of(SOLID, shape), R, tuple(p.tolist()), 0.0)
    rng, told = np.random.default_rng(4), set()
    for _ in range(300):
        x = rng.integers(-1, 5, 3) / 2.0
        dx = rng.integers(-1, 2, 3) * 2.0**-60
        y, dy = R @ x + p, R @ dx
        told.add(got := where_is(posed, (*y.tolist(), *dy.tolist())))
        cells = [[(c, xi, d) for c, xi, d in zip((*ij, 0), x, dx, strict=True)] for ij in CELLS]
        within = any(all(is_between(*one, closed=False) for one in cell) for cell in cells)
        closed = any(all(is_between(*one, closed=True) for one in cell) for cell in cells)
        if within:
            assert got == INSIDE
        elif not closed:
            assert got == OUTSIDE
        else:  # on the surface, or on a wall that two cells have in common
            assert got in (UNDECIDED, INSIDE)
    assert told == {INSIDE, OUTSIDE, UNDECIDED}


def test_places_on_a_triangle_are_in_its_plane():
    T = tuple((*v, 0.0, 0.0, 0.0) for v in ((0.1, 0.7, 0.3), (1.3, 0.7, 0.1), (0.9, 0.7, 3.3)))
    for shares in PLACES:
        assert sum(shares) == 32.0
        x, y, z, *rest = place_on(T, shares)
        assert 0.1 < x < 1.3
        assert y == 0.7
        assert rest[1] == 0.0
        assert 0.1 < z < 3.3


def test_which_rotations_round_nothing():
    assert all(swaps_axes(R) for R in TURNS.values())
    assert not swaps_axes(np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]))
    assert not swaps_axes(np.eye(3) + 1e-17 * (1 - np.eye(3)))
