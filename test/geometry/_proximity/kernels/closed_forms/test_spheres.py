"""Sphere against everything: truth with 50 digits, laws, and the documented choices."""

import numpy as np
import pytest
from numba import config
from oracles.forms import ALIGNED
from oracles.pairs import check, check_kernel, pair_of

from drake_geom_ros.geometry._proximity.kernels.closed_forms import spheres
from drake_geom_ros.geometry._proximity.kinds import ShapeKind
from truth.bodies.random_bodies import random_rotation

SAMPLES = 2 if config.DISABLE_JIT else 12


def _kernel(kind_B):
    return getattr(spheres, f'sphere_{ShapeKind(kind_B).name.lower()}')


def _pair(radius, kind_B, size_B, p_AB_W, R_WB=ALIGNED):
    """A sphere and a shape, with its axes along World's unless it is turned."""
    return pair_of(1, [radius], np.eye(3), kind_B, size_B, R_WB, p_AB_W)


@pytest.mark.parametrize('kind_B', [1, 2, 3, 4, 5, 6])
def test_truth_and_laws(kind_B):
    check_kernel(_kernel(kind_B), (1, kind_B), seed=kind_B, samples=SAMPLES)


def test_concentric_spheres_take_the_x_axis_of_b():
    R_WB = random_rotation(np.random.default_rng(1))
    pair = _pair(0.1, 1, [0.2], [0.0, 0.0, 0.0], R_WB)
    row = check(_kernel(1), pair)
    assert not row.unique
    assert row.distance == pytest.approx(-0.3, rel=1e-15)
    np.testing.assert_array_equal(row.nhat, R_WB[:, 0])


@pytest.mark.parametrize('offset', [1e-12, 1e-9, 1e-6])
def test_spheres_almost_concentric_keep_their_direction(offset):
    """Peers hang for these."""
    row = check(_kernel(1), _pair(0.5, 1, [0.25], [0.0, offset, 0.0]))
    assert row.unique
    np.testing.assert_array_equal(row.nhat, [0.0, -1.0, 0.0])


@pytest.mark.parametrize(
    ('size_B', 'p_AB_W', 'distance', 'nhat', 'unique'),
    [
        ([0.5, 0.5, 0.5], [0.5, 0.5, 0.5], -0.1, [-1, 0, 0], False),  # centred on a corner
        ([0.5, 0.5, 0.5], [0.0, 0.5, 0.0], -0.1, [0, -1, 0], True),  # on a face
        ([0.5, 0.5, 0.5], [0.0, 0.0, 0.0], -0.6, [1, 0, 0], False),  # in the middle
        ([1.0, 1.0, 1.0], [0.0, -0.3, 0.0], -0.8, [0, 1, 0], True),  # within
        ([0.5, 0.5, 5e-5], [0.0, 0.0, 0.04], -0.06005, [0, 0, -1], True),  # a plate across it
    ],
)
def test_sphere_in_a_box(size_B, p_AB_W, distance, nhat, unique):
    row = check(_kernel(2), _pair(0.1, 2, size_B, p_AB_W))
    assert row.distance == pytest.approx(distance, rel=1e-14)
    np.testing.assert_allclose(row.nhat, nhat, rtol=0, atol=1e-15)
    assert row.unique == unique


@pytest.mark.parametrize('depth', [1e-6, 1e-4, 5e-3, 8.5e-3, 1e-2])
def test_depth_stays_linear_past_full_entry(depth):
    """A small sphere that sinks into a big box (MuJoCo issue 2206)."""
    row = check(_kernel(2), _pair(5e-3, 2, [0.5, 0.5, 0.25], [0.0, 0.0, depth - 0.255]))
    assert row.distance == pytest.approx(-depth, rel=1e-9)


def test_sphere_on_the_axis_of_a_cylinder_leaves_through_the_barrel():
    """Not through the far end (DART pull request 3324)."""
    row = check(_kernel(4), _pair(0.2, 4, [1.0, 10.0], [0.0, 0.0, -9.0]))
    assert row.distance == pytest.approx(-1.2, rel=1e-15)
    assert not row.unique


@pytest.mark.parametrize('size_B', [(0.25, 0.25, 0.25), (0.25, 0.25, 0.26), (1e-3, 1.0, 1.0)])
@pytest.mark.parametrize('offset', [0.0, 1e-6, 1e-3])
def test_sphere_at_the_centre_of_an_ellipsoid(size_B, offset):
    """Drake hangs for the first two."""
    row = check(_kernel(5), _pair(0.1, 5, size_B, [0.0, 0.0, offset]))
    assert row.distance == pytest.approx(-0.1 - min(size_B), abs=2 * offset + 1e-15)


@pytest.mark.parametrize(
    ('size_B', 'p_AB_W'),
    [
        ((1e-3, 1e-3, 1.0), (0.25, 0.1, 0.3)),
        ((1e-3, 1e-3, 1.0), (0.0, 0.0, 1.11)),
        ((1.0, 1.0, 1e-3), (0.3, 0.4, 0.1)),
        ((1.0, 1.0, 1e-3), (0.3, 0.4, 0.05)),
        ((1e-3, 1e-3, 1.0), (0.05, 0.05, 0.2)),
    ],
)
def test_ellipsoids_of_aspect_ratio_1000(size_B, p_AB_W):
    row = check(_kernel(5), _pair(0.1, 5, size_B, p_AB_W))
    assert row.error_bound < 1e-13


@pytest.mark.parametrize('gap', [1e-7, -1e-7])
def test_micrometre_sphere_at_a_metre_box(gap):
    row = check(_kernel(2), _pair(1e-6, 2, [0.5, 0.5, 0.5], [0.0, 0.0, -0.5 - 1e-6 - gap]))
    assert row.distance == pytest.approx(gap, abs=1e-15)
    np.testing.assert_array_equal(row.nhat, [0.0, 0.0, 1.0])


def test_half_space_from_far_below():
    row = check(_kernel(6), _pair(0.5, 6, [], [1e3, 0.0, 10.0]))
    assert row.distance == pytest.approx(-10.5, rel=1e-15)
