"""Box, capsule, cylinder and ellipsoid against a half space."""

from fractions import Fraction

import numpy as np
import pytest
from numba import config
from oracles.forms import ALIGNED, hull_of
from oracles.kernel_calls import call_for_pair
from oracles.pairs import check, check_kernel, pair_of, turned

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    PAIR_WIDTH,
)
from drake_geom_ros.geometry._proximity.kernels.closed_forms import half_spaces
from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE, ShapeKind
from truth.bodies.random_bodies import random_rotation
from truth.tolerances import EPS

SAMPLES = 2 if config.DISABLE_JIT else 12
SIZES = {2: [0.5, 0.25, 1.0], 3: [0.25, 0.5], 4: [0.25, 0.5], 5: [0.5, 0.25, 1.0]}
# Height of the centre of each when it stands upright on the plane.
HEIGHTS = {2: 1.0, 3: 0.75, 4: 0.5, 5: 1.0}


def _kernel(kind_A):
    return getattr(half_spaces, f'{ShapeKind(kind_A).name.lower()}_half_space')


def _upright(kind_A, height, R_WA=ALIGNED):
    """A shape, upright unless it is turned, its origin at a height [m] over the half space."""
    p_AB_W = np.array([0.0, 0.0, -height])
    return pair_of(kind_A, SIZES[kind_A], R_WA, 6, (), np.eye(3), p_AB_W)


@pytest.mark.parametrize('kind_A', [2, 3, 4, 5])
def test_truth_and_laws(kind_A):
    check_kernel(_kernel(kind_A), (kind_A, 6), seed=kind_A, samples=SAMPLES)


@pytest.mark.parametrize('kind_A', [2, 3, 4, 5])
@pytest.mark.parametrize('gap', [1e-3, 0.0, -1e-3, -10.0])
def test_standing_upright_it_meets_the_plane_below_its_centre(kind_A, gap):
    row = check(_kernel(kind_A), _upright(kind_A, HEIGHTS[kind_A] + gap))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    assert row.unique
    np.testing.assert_array_equal(row.nhat, [0.0, 0.0, 1.0])
    np.testing.assert_allclose(row.p_ACa, [0.0, 0.0, -HEIGHTS[kind_A]], rtol=0, atol=1e-15)


@pytest.mark.parametrize('scale', [1e-9, 1.0])
@pytest.mark.parametrize('kind_A', [2, 3, 4, 5])
def test_standing_upright_under_any_common_rotation(kind_A, scale):
    """The midpoint of the lowest face is taken in spite of the rounding of the poses."""
    rng = np.random.default_rng(kind_A)
    for _ in range(20):
        R = random_rotation(rng)
        row = check(_kernel(kind_A), turned(_upright(kind_A, HEIGHTS[kind_A]), R).scaled(scale))
        lowest = [0, 0, -scale * HEIGHTS[kind_A]]
        np.testing.assert_allclose(R.T @ row.p_ACa, lowest, rtol=0, atol=1e-14 * scale)


@pytest.mark.parametrize(('kind_A', 'radius'), [(3, 0.25), (4, 0.25)])
def test_lying_it_meets_the_plane_at_the_middle_of_its_lowest_line(kind_A, radius):
    lying = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    row = check(_kernel(kind_A), _upright(kind_A, 0.2, lying))
    assert row.distance == pytest.approx(0.2 - radius, rel=1e-15)
    np.testing.assert_allclose(row.p_ACa, [0.0, 0.0, -radius], rtol=0, atol=1e-15)


def test_box_on_an_edge_meets_the_plane_at_the_middle_of_it():
    c = np.sqrt(0.5)
    tilted = np.array([[c, 0.0, c], [0.0, 1.0, 0.0], [-c, 0.0, c]])
    row = check(_kernel(2), _upright(2, 2.0, tilted))
    assert row.distance == pytest.approx(2.0 - 1.5 * c, rel=1e-15)
    assert row.p_ACa[1] == 0.0


@pytest.mark.parametrize('kind_A', [2, 3, 4, 5])
@pytest.mark.parametrize('scale', [1e-6, 1e-3, 1e6])
def test_scale(kind_A, scale):
    row = check(_kernel(kind_A), _upright(kind_A, 0.1).scaled(scale))
    assert row.distance == pytest.approx(scale * (0.1 - HEIGHTS[kind_A]), rel=1e-14)


@pytest.mark.parametrize('scale', [2.0**-20, 1.0, 2.0**20])
@pytest.mark.parametrize('far', [0.0, 1.0, 1e3])
def test_a_hull_is_as_far_as_its_lowest_vertex(scale, far):
    """In exact arithmetic; the bound is some roundings of the lengths, and no more."""
    rng = np.random.default_rng(8)
    for _ in range(SAMPLES):
        vertices = scale * rng.normal(size=(12, 3))
        R_WA, R_WB, p = (
            random_rotation(rng),
            random_rotation(rng),
            scale * far * rng.normal(size=3),
        )
        shape, out = hull_of(vertices), np.zeros(PAIR_WIDTH)
        pair = HALF_SPACE, np.zeros(0), R_WA, CONVEX, shape, R_WB, p
        call_for_pair(half_spaces.half_space_convex, *pair, 0.0, np.inf, out)
        exact = np.vectorize(Fraction)
        truth = (exact(p) + exact(vertices) @ exact(R_WB).T) @ exact(R_WA)[:, 2]
        lengths = np.linalg.norm(vertices, axis=1).max() + np.linalg.norm(p)
        off = abs(float(Fraction(out[DISTANCE]) - truth.min()))
        assert off <= out[ERROR_BOUND] <= 64 * EPS * lengths
