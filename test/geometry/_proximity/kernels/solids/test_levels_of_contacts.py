"""Cores a hair above or below the face of a solid: no level hides on which side they are."""

import math
from fractions import Fraction
from itertools import islice

import mpmath
import numpy as np
import pytest
from numba import config
from oracles.forms import kernel_form, row_of

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry import ACCURACY_GAPS
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.solids.plain_overlap import plain_overlap
from drake_geom_ros.geometry._proximity.tolerances import TOUCHING_DEPTH
from truth.bodies.grids import L, solid
from truth.bodies.random_bodies import random_rotation

MOST_SEEDS = 400
CASES = 3 if config.DISABLE_JIT else MOST_SEEDS
SIZE = 4.0  # of a pair [m], about
FLOOR = 1.0  # height of the upper face of the L, z [m]


def _cylinder(rng):
    return Body('Cylinder', (rng.uniform(0.05, 0.3), rng.uniform(0.1, 0.6)))


def _ellipsoid(rng):
    return Body('Ellipsoid', tuple(rng.uniform(0.05, 0.3, 3)))


def _capsule(rng):
    return Body('Capsule', (rng.uniform(0.05, 0.3), rng.uniform(0.1, 0.6)))


def _box(rng):
    return Body('Box', tuple(rng.uniform(0.1, 0.6, 3)))


CORES = [_cylinder, _ellipsoid, _capsule, _box]


def reach_below(core):
    """Return how far below its origin a turned core reaches, by its closed form in 50 digits."""
    x, y, z = (mpmath.mpf(float(c)) for c in core.R[2])
    size = [mpmath.mpf(float(s)) for s in core.size]
    if core.kind == 'Cylinder':
        return size[0] * mpmath.sqrt(x * x + y * y) + size[1] / 2 * abs(z)
    if core.kind == 'Capsule':
        return size[0] * mpmath.sqrt(x * x + y * y + z * z) + size[1] / 2 * abs(z)
    if core.kind == 'Ellipsoid':
        return mpmath.sqrt(sum((s * c) ** 2 for s, c in zip(size, (x, y, z), strict=True)))
    return sum(s / 2 * abs(c) for s, c in zip(size, (x, y, z), strict=True))


def stand(rng):
    """Return a rotation, and how far its origin may be beside the middle of the floor [m].

    What stands upright or lies has its lowest point right below its origin.
    """
    if rng.random() < 0.7:
        return np.roll(np.eye(3), rng.integers(3), axis=0), 0.45
    return random_rotation(rng), 0.01


def placed(make, seed):
    """Return a core near the floor of an L, the L, and the signed distance of both [m].

    Half of the pairs are turned together, which changes no distance.
    """
    rng = np.random.default_rng(seed)
    core = make(rng)
    R, aside = stand(rng)
    core = core.placed(R, np.zeros(3))
    height = Fraction(int(rng.choice([-1, 1]))) / 2 ** int(rng.integers(20, 45))
    z = FLOOR + float(reach_below(core)) + float(height)
    truth = float(mpmath.mpf(z) - FLOOR - reach_below(core))
    x, y = rng.uniform(0.5 - aside, 0.5 + aside, 2)
    pair = core.at(np.array([x, y, z])), solid(L)
    if rng.random() < 0.5:
        R = random_rotation(rng)
        pair = tuple(body.moved(R, np.zeros(3)) for body in pair)
    return *pair, truth


def is_plain(A, B):
    """Return whether the query for a collision takes the pair without asking its kernel."""
    shaped = [calling.OrientedShape(*kernel_form(body), body.R) for body in (A, B)]
    out = np.full(calling.PAIR_WIDTH, np.nan)
    plain_overlap(*shaped, B.p - A.p, calling.Aim(0.0, 0.0, 0.0, 0.0), out)
    return out[calling.DISTANCE] < 0.0


@pytest.mark.parametrize('level', ACCURACY_GAPS)
@pytest.mark.parametrize('make', CORES, ids=lambda make: make.__name__[1:])
def test_the_interval_of_each_level_holds_the_distance(make, level):
    with mpmath.workdps(50):
        for seed in range(CASES):
            A, B, truth = placed(make, seed)
            out = row_of(A, B, ACCURACY_GAPS[level] * 0.1)
            distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
            slack = 16.0 * math.ulp(SIZE)
            assert distance - bound - slack <= truth <= distance + bound + slack, (seed, truth)


@pytest.mark.parametrize('gap', [1e-13, 1e-12, 3.98e-10])
def test_an_ellipsoid_that_may_overlap_is_no_farther_than_it_is_seen(gap):
    """Beside the edge of a face, where its lowest point is on a triangle's diagonal."""
    ellipsoid = Body('Ellipsoid', (0.25, 0.5, 0.375))
    for x in np.arange(0.125, 1.0, 0.125):
        for y in np.arange(0.125, 1.0, 0.125):
            A = ellipsoid.at(np.array([x, y, FLOOR + 0.375 + gap]))
            out = row_of(A, solid(L), ACCURACY_GAPS['fast'] * 0.25)
            truth = Fraction(A.p[2]) - Fraction(0.375) - Fraction(FLOOR)
            distance, bound = out[calling.DISTANCE], out[calling.ERROR_BOUND]
            assert distance - bound <= truth <= distance + bound, (x, y)


@pytest.mark.parametrize('level', ACCURACY_GAPS)
@pytest.mark.parametrize('make', CORES, ids=lambda make: make.__name__[1:])
def test_what_plainly_overlaps_penetrates_at_every_level(make, level):
    with mpmath.workdps(50):
        placements = (placed(make, seed)[:2] for seed in range(MOST_SEEDS))
        plain = list(islice((pair for pair in placements if is_plain(*pair)), CASES))
        assert plain
        for A, B in plain:
            out = row_of(A, B, ACCURACY_GAPS[level] * 0.1)
            assert out[calling.DISTANCE] < -TOUCHING_DEPTH * SIZE, (A, B)
