"""Overlaps of solids that are seen without a depth: none that is not, and most that are."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import config
from oracles.forms import kernel_form
from oracles.hard_cases.interlocked import depth_of, of_cells, polycube

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling import pairs as calling
from drake_geom_ros.geometry._proximity.kernels.solids.pairs import signed_distance_to_solid
from drake_geom_ros.geometry._proximity.kernels.solids.plain_overlap import (
    depth_at_crossing,
    plain_overlap,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import SolidPair, body_of, solid_of
from drake_geom_ros.geometry._proximity.kinds import SOLID
from truth.bodies.grids import L, solid
from truth.bodies.random_bodies import random_rotation
from truth.bodies.tori import torus

CASES = 12 if config.DISABLE_JIT else 160
LINES = [np.arange(9.0)] * 3
CORES = [
    Body('Sphere', (0.3,)),
    Body('Box', (0.4, 0.6, 0.5)),
    Body('Capsule', (0.2, 0.6)),
    Body('Cylinder', (0.25, 0.6)),
    Body('Ellipsoid', (0.2, 0.3, 0.4)),
    Body('Convex', np.random.default_rng(3).uniform(-0.3, 0.3, (12, 3))),
]


def told(A, B):
    """What is told without a depth, and by the pair's kernel (PAIR_WIDTH,)."""
    A, B = sorted((A, B), key=lambda body: kernel_form(body)[0])
    shaped = [calling.OrientedShape(*kernel_form(body), body.R) for body in (A, B)]
    aim, p = (
        calling.Aim(size=0.0, tolerance=1e-9, cutoff=np.inf, accuracy=0.0),
        np.subtract(B.p, A.p),
    )
    plain, row = np.full(calling.PAIR_WIDTH, np.nan), np.zeros(calling.PAIR_WIDTH)
    plain_overlap(*shaped, p, aim, plain)
    signed_distance_to_solid(*shaped, p, aim, row)
    return plain[calling.DISTANCE], row


def is_told(A, B):
    """Whether an overlap is plain; it is one then, and no deeper than it is."""
    plain, row = told(A, B)
    assert plain <= 0.0
    if plain < 0.0:
        assert row[calling.DISTANCE] < 0.0
        assert row[calling.DISTANCE] - row[calling.ERROR_BOUND] <= plain
    return plain < 0.0


@pytest.mark.parametrize('turned', [False, True])
def test_no_touch_is_an_overlap_and_most_overlaps_of_lattices_are_plain(turned):
    """Where walls are flush no triangles go through each other, and boxes tell."""
    plain = count = 0
    for seed in range(CASES):
        rng = np.random.default_rng([seed, 36])
        n = int(rng.integers(2, 4))
        mine, its = (polycube(rng, n, int(rng.integers(3, max(4, n**3 // 2)))) for _ in range(2))
        p = rng.integers(-8 * n, 8 * n + 1, 3) / 8.0
        A, B = of_cells(mine, LINES).at(p), of_cells(its, LINES)
        if {kernel_form(A)[0], kernel_form(B)[0]} != {SOLID}:
            continue
        depth = depth_of(mine, its, p)
        if turned:
            R = random_rotation(rng)
            A, B = A.moved(R, np.zeros(3)), B.moved(R, np.zeros(3))
        seen = is_told(A, B)
        assert not seen or depth > 0.0
        plain, count = plain + seen, count + (depth > 0.0)
    assert count > (2 if config.DISABLE_JIT else 40)
    assert plain >= 0.95 * count


@given(st.integers(0, 2**32 - 1))
def test_tori_that_cross_are_told_and_linked_ones_are_not(seed):
    rng = np.random.default_rng(seed)
    ring = torus(12, 10)
    upright = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    at = np.array([1.0, 0.0, 0.0]) + rng.uniform(-0.25, 0.25, 3) * (rng.integers(2) * 2.0)
    one, other = ring.placed(upright, at), ring
    R, far = random_rotation(rng), rng.uniform(-9.0, 9.0, 3)
    one, other = one.moved(R, far), other.moved(R, far)
    _, row = told(one, other)
    plain = is_told(one, other)
    assert plain == is_told(other, one) or abs(row[calling.DISTANCE]) < 1e-3
    if row[calling.DISTANCE] + row[calling.ERROR_BOUND] < -1e-2:
        assert plain
    if row[calling.DISTANCE] > 0.0:
        assert not plain


@pytest.mark.parametrize('core', CORES, ids=lambda body: body.kind)
@given(seed=st.integers(0, 2**32 - 1))
def test_cores_are_in_a_solid_only_if_they_are(core, seed):
    rng = np.random.default_rng(seed)
    is_told(core.placed(random_rotation(rng), rng.uniform(-0.5, 2.5, 3)), solid(L))


@pytest.mark.parametrize('core', CORES, ids=lambda body: body.kind)
def test_a_core_wholly_within_a_solid_is_told(core):
    assert is_told(core.at(np.array([0.5, 0.5, 0.5])), solid(L))


def test_a_solid_wholly_within_another_is_told_and_one_in_its_cavity_is_not():
    small = solid(L, scale=0.1)
    assert is_told(small.at(np.array([0.3, 0.3, 0.3])), solid(L))
    assert is_told(solid(L), small.at(np.array([0.3, 0.3, 0.3])))
    cells = [c for c in np.ndindex(5, 5, 5) if not all(1 <= x <= 3 for x in c)]
    hollow = of_cells(np.array(cells), LINES)
    assert not is_told(small.at(np.array([2.0, 2.0, 2.0])), hollow)
    assert is_told(small.at(np.array([0.3, 2.0, 2.0])), hollow)


@pytest.mark.parametrize('deep', [0.0, 1e-15, 1e-14, 1e-9, 1e-3])
def test_walls_that_are_flush_leave_it_to_the_kernel(deep):
    one = solid(L)
    seen = is_told(one.at(np.array([0.0, 0.0, 1.0 - deep])), one)
    assert not seen or deep >= 1e-9


def test_of_what_does_not_cross_no_depth_is_proved():
    """Of parallel triangles no line is common, and of others the middle of none."""
    one = solid(L)
    kind, shape = kernel_form(one)
    A, B = body_of(kind, shape, np.eye(3)), solid_of(shape)
    pair = SolidPair(A, B, (0.0, 0.0, 1.0), 8.0, 1e-9, 0.0)
    for i in range(A.tree.triangles):
        for j in range(B.tree.triangles):
            assert depth_at_crossing(pair, i, j, 1e-9) <= 0.0
