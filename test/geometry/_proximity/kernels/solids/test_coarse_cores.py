"""Cores beside solids to an accuracy that is wanted: bounds hold the truth of boxes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import config
from oracles.accuracies import at_gap, check_parts, check_rows, row_to
from oracles.solids import solid

from drake_geom_ros.cross_check.bodies import Body
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
)
from drake_geom_ros.geometry._proximity.tolerances import COARSE
from truth.bodies.mesh_bodies import mesh_body
from truth.bodies.random_bodies import random_body, random_directions, random_rotation

EXAMPLES = 5 if config.DISABLE_JIT else 60
KINDS = ('Sphere', 'Box', 'Capsule', 'Cylinder', 'Ellipsoid', 'Convex')


def core_of(rng, kind, size):
    """Return a core about a third as large as the solids below, or a large hull with lists."""
    corners = int(rng.choice([4, 20, 600])) if kind == 'Convex' else 0
    return random_body(rng, kind, corners).scaled(2.0 * size)


@settings(max_examples=EXAMPLES)
@given(
    seed=st.integers(0, 2**32 - 1),
    kind=st.sampled_from(KINDS),
    name=st.sampled_from(['L', 'U', 'ring']),
    gap=st.sampled_from([None, 1e-12, 1e-7, 1e-4, 2e-3, 0.05]),
    size=st.sampled_from([1e-3, 0.1, 1.0, 1e3]),
)
def test_bounds_hold_the_distance_of_cores_from_unions_of_boxes(seed, kind, name, gap, size):
    rng = np.random.default_rng(seed)
    b = solid(name, size, int(rng.choice([1, 4])))
    a = core_of(rng, kind, size).placed(random_rotation(rng), size * rng.uniform(-3.0, 5.0, 3))
    if rng.random() < 0.3:
        a = a.placed(np.eye(3), size * np.round(4.0 * rng.uniform(-1.0, 4.0, 3)) / 4.0)
    if gap is not None:
        b = at_gap(a, b, gap * size)
    check_parts(a, b, size)


@settings(max_examples=EXAMPLES // 3)
@given(
    seed=st.integers(0, 2**32 - 1),
    kind=st.sampled_from(KINDS),
    gap=st.sampled_from([None, 1e-6, 1e-3, 0.03]),
)
def test_bounds_hold_the_distance_of_cores_from_dents(seed, kind, gap):
    rng = np.random.default_rng(seed)
    a = core_of(rng, kind, 0.1).placed(random_rotation(rng), np.zeros(3))
    direction = random_directions(rng, 1)[0]
    b = mesh_body('Ball', 100 if config.DISABLE_JIT else 1300)
    b = b.placed(random_rotation(rng), rng.uniform(0.0, 0.4) * direction)
    if gap is not None:
        b = at_gap(a, b, gap)
    check_rows(a, b, 1.0)


@pytest.mark.parametrize('kind', KINDS)
def test_hulls_that_are_apart_decide_at_every_accuracy(kind):
    a = core_of(np.random.default_rng(3), kind, 0.1).at(np.array([0.6, 0.2, 0.1]))
    b = mesh_body('L', 100)
    for accuracy in (COARSE, 1e-4, 1e-3, 1e-2):
        assert 0.25 * accuracy <= row_to(a, b, accuracy)[ERROR_BOUND] <= accuracy
    exact = row_to(a, b, 0.0)
    assert (row_to(a, b, 0.99 * COARSE) == exact).all()


@pytest.mark.parametrize('kind', KINDS)
def test_in_a_dent_the_kernel_of_exact_answers(kind):
    """The inner edge of the L is at its origin, and its hull reaches beyond that."""
    a = random_body(np.random.default_rng(4), kind, 20).scaled(0.05)
    a = a.at(np.array([0.02, 0.02, 0.0]))
    b = mesh_body('L', 100)
    exact = row_to(a, b, 0.0)
    assert exact[DISTANCE] > 1e-3
    assert (row_to(a, b, 1e-3) == exact).all()


def test_a_core_in_the_wall_of_a_solid_overlaps_at_every_accuracy():
    a, b = Body('Box', (0.02, 0.02, 0.02)), mesh_body('L', 100)
    a = a.at(np.array([-0.095, -0.05, 0.0]))
    for accuracy in (0.0, COARSE, 1e-3, 1e-2, 0.1):
        out = row_to(a, b, accuracy)
        assert out[DISTANCE] < 0.0
        assert abs(out[DISTANCE] + 0.015) <= out[ERROR_BOUND] + 1e-12
