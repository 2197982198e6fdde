"""How tight the depth of solids is: random polycubes, whose truth is found by all places."""

import numpy as np
import pytest
from numba import config
from oracles.forms import HERE, kernel_form, row_of
from oracles.hard_cases.interlocked import depth_of, of_cells, polycube

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import MESH, OPEN, SOLID
from truth.bodies.grids import surface
from truth.bodies.random_bodies import random_rotation

CASES = 12 if config.DISABLE_JIT else 160
LINES = [np.arange(9.0)] * 3
SHARE = 0.1  # of the depth: what counts as tight


def pairs(turned):
    """Pairs of solids that overlap, with their depth."""
    for seed in range(CASES):
        rng = np.random.default_rng([seed, 35])
        n = int(rng.integers(2, 4))
        mine, its = (polycube(rng, n, int(rng.integers(3, max(4, n**3 // 2)))) for _ in range(2))
        p = rng.integers(-8 * n, 8 * n + 1, 3) / 8.0
        depth = depth_of(mine, its, p)
        A, B = of_cells(mine, LINES), of_cells(its, LINES)
        if depth == 0.0 or {kernel_form(A)[0], kernel_form(B)[0]} != {SOLID}:
            continue
        A = A.at(p)
        if turned:
            R = random_rotation(rng)
            A, B = A.moved(R, HERE), B.moved(R, HERE)
        yield A, B, depth


@pytest.mark.parametrize('turned', [False, True])
def test_nine_of_ten_depths_are_within_a_tenth_and_none_is_wrong(turned):
    tight = close = count = 0
    for A, B, depth in pairs(turned):
        for a, b in ((A, B), (B, A)):
            out = row_of(a, b)
            distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
            assert abs(distance + depth) <= bound + 1e-12 * turned
            assert (out[calling.METHOD] == OPEN) == (bound > SHARE * -distance)
            assert out[calling.METHOD] in (MESH, OPEN)
            tight += bound <= SHARE * depth
            close += abs(distance + depth) <= SHARE * depth
            count += 1
    assert count > (2 if config.DISABLE_JIT else 40)
    assert tight >= 0.9 * count
    assert close >= 0.9 * count


def test_a_box_in_the_wall_of_a_cavity():
    """A wall of 1 m around a cavity of 3 m; the box goes 0.2 m into a wall."""
    cells = [c for c in np.ndindex(5, 5, 5) if not all(1 <= x <= 3 for x in c)]
    vertices, triangles = (np.array(x) for x in surface(cells, LINES))
    hollow = Body('Solid', vertices, triangles=triangles)
    for axis in range(3):
        at = np.full(3, 2.5)
        at[axis] += 1.2
        out = row_of(Body('Box', (1.0, 1.0, 1.0), p=at), hollow)
        assert out[calling.DISTANCE] == pytest.approx(-0.2, abs=1e-12)
        assert out[calling.ERROR_BOUND] <= 1e-11
        assert out[calling.METHOD] == MESH
