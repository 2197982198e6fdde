"""Depths in solids to an accuracy that is wanted: bounds hold the truth of polycubes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.accuracies import row_to
from oracles.forms import HERE, kernel_form
from oracles.hard_cases.interlocked import depth_of, of_cells, polycube

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
)
from drake_geom_ros.geometry._proximity.kinds import MESH, OPEN, SOLID
from drake_geom_ros.geometry._proximity.tolerances import COARSE
from truth.bodies.mesh_bodies import mesh_body
from truth.bodies.random_bodies import random_body, random_rotation

EXAMPLES = 3 if config.DISABLE_JIT else 40
LINES = [np.arange(9.0)] * 3
ACCURACIES = (3.0, 1.0, 0.3, 0.1, 0.01, 1e-3, COARSE, 0.0)  # [m], larger ones first


def polycubes(rng):
    """Return two solids of unit cells that may overlap, and how deep they do [m]."""
    n = int(rng.integers(2, 4))
    cells = [polycube(rng, n, int(rng.integers(3, max(4, n**3 // 2)))) for _ in range(2)]
    p = rng.integers(-8 * n, 8 * n + 1, 3) / 8.0
    A, B = (of_cells(each, LINES) for each in cells)
    return A.at(p), B, depth_of(*cells, p)


def check_depths(a, b, rounding):
    """Check the laws of accuracies among the rows of a pair that overlaps; return the rows."""
    rows = [row_to(a, b, accuracy) for accuracy in ACCURACIES]
    assert rows[-1][DISTANCE] < 0.0
    for accuracy, out, closer in zip(ACCURACIES, rows, [*rows[1:], rows[-1]], strict=True):
        assert out[DISTANCE] < 0.0
        assert out[METHOD] in (MESH, OPEN)
        # A smaller length never has wider bounds, and none beyond those of a larger one.
        assert closer[ERROR_BOUND] <= out[ERROR_BOUND] + rounding, accuracy
        assert closer[DISTANCE] >= out[DISTANCE] - rounding
        shallowest = out[DISTANCE] + out[ERROR_BOUND]
        assert shallowest < 0.0 or rows[-1][DISTANCE] + rows[-1][ERROR_BOUND] >= 0.0
        assert closer[DISTANCE] + closer[ERROR_BOUND] <= shallowest + rounding
        # The translation separates: nothing overlaps for certain, nor at all a little farther on.
        nearby, beyond = (
            row_to(a.at(a.p - (out[DISTANCE] - more) * out[NORMAL : NORMAL + 3]), b, 0.0)
            for more in (16.0 * rounding, 1e-8)
        )
        assert nearby[DISTANCE] + nearby[ERROR_BOUND] >= 0.0
        assert beyond[DISTANCE] >= 0.0
        assert (row_to(a, b, accuracy) == out).all()  # whatever was asked before
    return rows


@pytest.mark.parametrize('turned', [False, True])
@settings(max_examples=EXAMPLES)
@given(seed=st.integers(0, 2**32 - 1))
def test_bounds_hold_the_depth_of_polycubes(turned, seed):
    rng = np.random.default_rng(seed)
    A, B, depth = polycubes(rng)
    if depth == 0.0 or {kernel_form(A)[0], kernel_form(B)[0]} != {SOLID}:
        return
    if turned:
        R = random_rotation(rng)
        A, B = A.moved(R, HERE), B.moved(R, HERE)
    for out in check_depths(A, B, 1e-12):
        assert abs(out[DISTANCE] + depth) <= out[ERROR_BOUND] + 1e-12 * turned


@settings(max_examples=EXAMPLES)
@given(
    seed=st.integers(0, 2**32 - 1),
    kind=st.sampled_from(['Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Convex', 'Ball']),
    deep=st.sampled_from([1e-4, 2e-3, 0.03]),
)
def test_accuracies_agree_about_bodies_in_a_ball_with_dents(seed, kind, deep):
    rng = np.random.default_rng(seed)
    B = mesh_body('Ball', 100)
    A = B if kind == 'Ball' else random_body(rng, kind, 20)
    A = A.placed(random_rotation(rng), rng.uniform(0.2, 0.5, 3))
    apart = row_to(A, B, 0.0)
    if not apart[DISTANCE] > 0.0:
        return
    A = A.at(A.p - (apart[DISTANCE] + deep) * apart[NORMAL : NORMAL + 3])
    if row_to(A, B, 0.0)[DISTANCE] < -1e-9:
        check_depths(A, B, 1e-11)


def test_a_shallow_depth_ends_early_within_what_is_wanted():
    ball = mesh_body('Ball', 1300)
    other = ball.at(np.array([0.0, 0.0, 0.25]))
    apart = row_to(other, ball, 0.0)
    other = other.at(other.p - (apart[DISTANCE] + 5e-3) * apart[NORMAL : NORMAL + 3])
    exact, found = row_to(other, ball, 0.0), row_to(other, ball, 1e-3)
    assert found[DISTANCE] == pytest.approx(exact[DISTANCE], abs=1e-3)
    assert found[ERROR_BOUND] <= 1e-3


def test_a_body_in_the_wall_of_a_slot_leaves_it_by_the_shortest_way():
    """The move that separates the hulls is a hundred times as long."""
    lines = [np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 1.0, 9.0]), np.array([0.0, 1.0])]
    slot = of_cells([(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0)], lines)
    block = Body('Box', (0.8, 6.0, 0.8), p=np.array([1.37, 5.0, 0.5]))
    for accuracy in ACCURACIES:
        out = row_to(block, slot, accuracy)
        assert abs(out[DISTANCE] + 0.03) <= out[ERROR_BOUND] + 1e-12
        if accuracy <= 0.1:
            assert out[DISTANCE] == pytest.approx(-0.03, abs=0.1)
