"""Bodies that fit between walls, turned: by fractions, of the numbers that kernels are handed.

A body between two walls of a slot, down to its floor, is in them if it is wider than the slot is,
by however little, and then it has to go up; else it touches. Rotations round, and so nobody can
tell by floats: an answer holds whatever fractions say.
"""

from fractions import Fraction

import numpy as np
import pytest
from numba import config
from oracles.forms import HERE, row_of
from oracles.hard_cases.interlocked import CAP_AND_STEM, CELLS, SLOT, of_cells

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kinds import OPEN
from truth.bodies.random_bodies import random_rotation

SEEDS = 3 if config.DISABLE_JIT else 24
MORE = [0.0, 2.0**-52, -(2.0**-52), 1e-15, -1e-15, 1e-14, -1e-14, 1e-12, -1e-12]
WALL = of_cells(SLOT, CELLS)  # the slot is from x = 1 to 2, y = 1 to 2


def stem(kind, more):
    """A body in the slot, as wide as that and ``more``, and its corners, or radius, there."""
    half = 0.5 * (1.0 + more)
    middle = np.array([1.5, 1.5, 0.5])
    if kind == 'T':
        lines = [[0.5, 1.5 - half, 1.5 + half, 2.5], [1.0, 2.0, 2.5], [0.0, 1.0]]
        body = of_cells(CAP_AND_STEM, lines)
        vertices = np.asarray(body.size)
        low = np.abs(vertices[:, 0] - 1.5) < 0.75
        return body, vertices[low], 0.0
    corners = np.array(list(np.ndindex(2, 2, 2))) * [2.0 * half, 1.0, 1.0] - [half, 0.5, 0.5]
    if kind == 'Box':
        return Body('Box', (2.0 * half, 1.0, 1.0), p=middle), corners, 0.0
    if kind == 'Convex':
        return Body('Convex', corners, p=middle), corners, 0.0
    if kind == 'Prism':  # of eight sides, two on the walls
        around = np.array([(1, 0.4), (0.4, 1), (-0.4, 1), (-1, 0.4)])
        around = np.vstack((around, -around))
        ring = np.column_stack((half * around[:, 0], 0.5 * around[:, 1]))
        corners = np.vstack([np.column_stack((ring, np.full(8, z))) for z in (-0.5, 0.5)])
        return Body('Convex', corners, p=middle), corners, 0.0
    if kind == 'Sphere':
        return Body('Sphere', (half,), p=middle), np.zeros((1, 3)), half
    return (
        Body('Capsule', (half, 0.25), p=middle),
        np.array([[0, 0, z] for z in (-0.125, 0.125)]),
        half,
    )


def exact(R, vs):
    """Points R v, as fractions."""
    return [[sum(Fraction(float(r)) * Fraction(float(x)) for r, x in zip(row, v, strict=True))
             for row in R] for v in vs]  # fmt: skip


def is_wider(A, corners, radius, B):
    """Whether a stem is wider than the slot, by fractions: along the walls' own normal.

    What kernels are handed are R_WA, R_WB and p_AB_W, and nothing of a wall is turned exactly.
    """
    along = exact(B.R, np.eye(3))
    y, z = along[1], along[2]
    n = [y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0]]

    def over(q):
        return sum(a * b for a, b in zip(n, q, strict=True))

    places = [over(q) for q in exact(A.R, corners)]
    left, right = (over(q) for q in exact(B.R, [(1, 0, 0), (2, 0, 0)]))
    room = right - left - (max(places) - min(places))
    ball = 2 * Fraction(radius)
    return room < 0 if radius == 0.0 else room < 0 or room**2 < ball**2 * over(n)


@pytest.mark.parametrize('kind', ['T', 'Box', 'Convex', 'Prism', 'Sphere', 'Capsule'])
def test_an_answer_holds_what_fractions_say(kind):
    told = set()
    for seed in range(SEEDS):
        rng = np.random.default_rng([seed, 35])
        R = random_rotation(rng)
        more = MORE[seed % len(MORE)]
        body, corners, radius = stem(kind, more)
        A, B = body.moved(R, HERE), WALL.moved(R, HERE)
        locked = is_wider(A, corners, radius, B)
        told.add(locked)
        for a, b in ((A, B), (B, A)) if kind == 'T' else ((A, B),):
            out = row_of(a, b)
            distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
            if locked:
                assert distance - bound <= -0.45
            else:
                assert distance + bound >= -1e-13
            if bound > 0.1:  # nobody can tell: the way out is one, and it may be none is needed
                assert out[calling.METHOD] == OPEN
                assert distance <= -0.45
                assert distance + bound >= 0.0 or abs(more) > 1e-14
    assert told == {True, False}


@pytest.mark.parametrize('more', [1e-12, -1e-12])
def test_what_is_wider_or_narrower_by_more_than_rounding_is_told_but_for_a_few(more):
    """What has so little room may be left open, where no step of some roundings parts it."""
    told = 0
    for seed in range(SEEDS):
        R = random_rotation(np.random.default_rng(seed))
        A, B = stem('T', more)[0].moved(R, HERE), WALL.moved(R, HERE)
        out = row_of(A, B)
        truth = -1.0 if more > 0.0 else 0.0
        assert abs(out[calling.DISTANCE] - truth) <= out[calling.ERROR_BOUND] + 2e-12
        told += out[calling.ERROR_BOUND] <= 1e-9
    assert told >= 0.9 * SEEDS


@pytest.mark.parametrize('kind', ['T', 'Box', 'Convex', 'Prism', 'Sphere', 'Capsule'])
def test_what_only_stands_on_a_floor_is_told_as_touching_however_it_is_turned(kind):
    """It may be in it by less than rounding, and then some roundings part it."""
    for seed in range(SEEDS):
        rng = np.random.default_rng([seed, 36])
        R = random_rotation(rng)
        body = stem(kind, 0.0)[0]
        beside = kind in ('Sphere', 'Capsule', 'Prism')
        A = body.at(body.p + np.array([1.0 if beside else 0.0, 1.0, 0.0]))
        out = row_of(A.moved(R, HERE), WALL.moved(R, HERE))
        assert abs(out[calling.DISTANCE]) <= 1e-13
        assert out[calling.ERROR_BOUND] <= 1e-12
        assert out[calling.METHOD] != OPEN
