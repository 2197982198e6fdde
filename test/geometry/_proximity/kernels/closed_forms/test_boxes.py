"""Box against box."""

import itertools

import numpy as np
import pytest
from numba import config
from oracles.forms import ALIGNED
from oracles.pairs import (
    check,
    check_kernel,
    evaluate,
    feature_pairs,
    moved_apart,
    pair_of,
    random_pairs,
    turned,
)
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry._proximity.kernels.closed_forms.boxes import box_box
from drake_geom_ros.geometry._proximity.kinds import BOX
from truth.bodies.random_bodies import random_rotation
from truth.references.convex import signed_distance

SAMPLES = 2 if config.DISABLE_JIT else 18


def _boxes(p_AB_W, size_A=(0.5, 0.5, 0.5), size_B=(0.5, 0.5, 0.5), R_WA=ALIGNED, R_WB=ALIGNED):
    return pair_of(BOX, size_A, R_WA, BOX, size_B, R_WB, p_AB_W)


def _about(axis, angle):
    """Rotation about a coordinate axis."""
    return Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()


def test_truth_and_laws():
    check_kernel(box_box, (2, 2), seed=22, samples=SAMPLES, special_step=3)


def test_boxes_that_meet_at_their_features():
    for pair in feature_pairs(np.random.default_rng(23), (2, 2), 8 * SAMPLES):
        check(box_box, pair)


def test_lattice_offsets_are_exact():
    """FCL and Drake are wrong in 30 of these 215, by up to 41 %."""
    for offset in itertools.product(range(6), repeat=3):
        row = evaluate(box_box, _boxes(offset))
        gaps = np.maximum(np.array(offset) - 1.0, 0.0)
        if max(offset) > 1:
            assert row.distance == pytest.approx(np.linalg.norm(gaps), rel=1e-15)
        else:
            assert row.distance == pytest.approx(max(offset) - 1.0, abs=1e-15)


@pytest.mark.parametrize('gap', [1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0, -1e-15, -1e-12, -1e-6, -1e-3])
def test_faces_meet_at_the_centre_of_their_patch(gap):
    for shift, centre in (
        ([0, 0], [0, 0]),
        ([0.3, 0.2], [0.15, 0.1]),
        ([-0.9, 0.0], [-0.45, 0.0]),
    ):
        row = check(box_box, _boxes([*shift, 1.0 + gap]))
        assert row.distance == pytest.approx(gap, abs=3e-16)
        np.testing.assert_array_equal(row.nhat, [0.0, 0.0, -1.0])
        np.testing.assert_allclose(row.p_ACa, [*centre, 0.5], rtol=0, atol=1e-14)
        assert row.unique


@pytest.mark.parametrize('gap', [1e-3, 1e-12, 0.0, -1e-12, -1e-3])
def test_face_normal_keeps_its_digits_under_any_common_rotation(gap):
    rng = np.random.default_rng(4)
    for _ in range(3 if config.DISABLE_JIT else 20):
        R = random_rotation(rng)
        turn = _about(2, rng.uniform(0, 2 * np.pi))
        row = check(box_box, turned(_boxes([0.1, 0.2, 1.0 + gap], R_WB=turn), R))
        np.testing.assert_allclose(R.T @ row.nhat, [0, 0, -1], rtol=0, atol=1e-15)
        assert row.distance == pytest.approx(gap, abs=3e-15)


@pytest.mark.parametrize('gap', [1e-3, 1e-9, 0.0, -1e-9, -1e-3])
def test_edge_across_edge(gap):
    """Each box stands on an edge; the edges cross at right angles."""
    pair = _boxes([0.1, 0.2, 2**0.5 + gap], R_WA=_about(0, np.pi / 4), R_WB=_about(1, np.pi / 4))
    row = check(box_box, pair)
    assert row.distance == pytest.approx(gap, abs=1e-15)
    np.testing.assert_allclose(row.nhat, [0, 0, -1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(row.p_ACa, [0.1, 0.0, 2**-0.5], rtol=0, atol=2e-15)
    assert row.unique


@pytest.mark.parametrize('gap', [0.2, 1e-3, 1e-6])
@pytest.mark.parametrize('direction', [(1, 0, 0), (1, -1, 0), (1, 1, -1)])
def test_faces_edges_and_vertices_that_face_each_other(direction, gap):
    offset = np.array(direction, dtype=float)
    row = check(box_box, _boxes(offset * (1 + gap)))
    assert row.distance == pytest.approx(gap * np.linalg.norm(offset), rel=1e-9)
    np.testing.assert_allclose(
        row.nhat, -offset / np.linalg.norm(offset), rtol=0, atol=1e-15 / gap
    )
    assert row.unique


@pytest.mark.parametrize('direction', [(1, 1, 0), (1, -1, 1)])
def test_touching_at_an_edge_or_a_vertex_takes_the_lowest_face(direction):
    row = check(box_box, _boxes(direction))
    assert row.distance == 0.0
    assert not row.unique
    np.testing.assert_array_equal(row.nhat, [-1.0, 0.0, 0.0])


@pytest.mark.parametrize('tilt', [1e-1, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16])
@pytest.mark.parametrize('gap', [1e-3, 0.0, -1e-6, -1e-3])
def test_faces_tilted_against_each_other(tilt, gap):
    for axis, shift in ((0, [0.0, 0.0]), (1, [0.3, 0.2]), (0, [0.9, -0.9])):
        check(box_box, _boxes([*shift, 1.0 + gap], R_WB=_about(axis, tilt)))


@pytest.mark.parametrize('tilt', [1e-2, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13, 1e-15])
def test_long_edges_nearly_parallel(tilt):
    """A crossed axis of nearly parallel edges is right to the last digit, or not chosen."""
    rng = np.random.default_rng(6)
    for _ in range(2 if config.DISABLE_JIT else 10):
        R = random_rotation(rng)
        R_WB = _about(2, np.pi / 4) @ _about(0, tilt)
        p = [0.1 * 2**0.5 + rng.uniform(-2, 2) * tilt, rng.uniform(-0.1, 0.1), rng.uniform(-2, 2)]
        pair = _boxes(p, (0.1, 0.1, 3.0), (0.1, 0.1, 2.0), _about(2, np.pi / 4), R_WB)
        check(box_box, turned(pair, R))


@pytest.mark.parametrize(
    ('p_AB_W', 'size_A', 'size_B', 'distance', 'nhat', 'unique'),
    [
        ([0, 0, 0], (1, 1, 1), (0.1, 0.1, 0.1), -1.1, [-1, 0, 0], False),
        ([0, -0.3, 0], (1, 1, 1), (0.1, 0.1, 0.1), -0.8, [0, 1, 0], True),
        ([0.3, 0.3, 0], (1, 1, 1), (0.1, 0.1, 0.1), -0.8, [-1, 0, 0], False),
        ([0.2, 0.3, 0], (1, 1, 1), (0.1, 0.1, 0.1), -0.8, [0, -1, 0], True),
        ([0, 0, 0], (0.5, 0.5, 0.5), (0.5, 0.5, 0.5), -1.0, [-1, 0, 0], False),
        ([0, 0, 0], (0.5, 0.4, 0.3), (0.5, 0.4, 0.3), -0.6, [0, 0, -1], False),
        ([0, 0, 0], (0.1, 0.1, 5e-5), (0.1, 5e-5, 0.1), -0.10005, [0, -1, 0], False),
        ([0, 0, 5e-5 + 0.5 + 1e-5], (0.5, 0.5, 0.5), (0.5, 0.5, 5e-5), 1e-5, [0, 0, -1], True),
        ([0, 0, 5e-5 + 0.5 - 1e-5], (0.5, 0.5, 0.5), (0.5, 0.5, 5e-5), -1e-5, [0, 0, -1], True),
        ([0.2, 0.1, 0.5 + 1.1e-6], (0.5, 0.5, 0.5), (1e-6,) * 3, 1e-7, [0, 0, -1], True),
        ([0.2, 0.1, 0.5 + 0.9e-6], (0.5, 0.5, 0.5), (1e-6,) * 3, -1e-7, [0, 0, -1], True),
        ([2.1e-6, 0, 0], (1e-6,) * 3, (1e-6,) * 3, 1e-7, [-1, 0, 0], True),
        ([1.9e-6, 0, 0], (1e-6,) * 3, (1e-6,) * 3, -1e-7, [-1, 0, 0], True),
        ([3.0, 2.0, 5000.501], (5e3,) * 3, (0.5,) * 3, 1e-3, [0, 0, -1], True),
        ([3.0, 2.0, 5000.499], (5e3,) * 3, (0.5,) * 3, -1e-3, [0, 0, -1], True),
    ],
)
def test_contained_flat_tiny_and_huge(p_AB_W, size_A, size_B, distance, nhat, unique):
    row = check(box_box, _boxes(p_AB_W, size_A, size_B))
    assert row.distance == pytest.approx(distance, rel=1e-12, abs=row.error_bound)
    np.testing.assert_allclose(row.nhat, nhat, rtol=0, atol=1e-15)
    assert row.unique == unique


@pytest.mark.parametrize('overlap', [1e-6, 1e-9, 1e-12, 0.0, -1e-12, -1e-9, -1e-8, -1e-6])
def test_faces_that_barely_face_each_other(overlap):
    """1 m apart, a sideways miss of 1e-8 m does not show in the distance, but the normal knows."""
    rng = np.random.default_rng(17)
    for _ in range(2 if config.DISABLE_JIT else 10):
        turn = _about(2, rng.integers(4) * np.pi / 2)
        R = random_rotation(rng)
        row = check(box_box, turned(_boxes([1.0 - overlap, 0.3, 2.0], R_WB=turn), R))
        miss = max(0.0, -overlap)
        expected = -np.array([miss, 0.0, 1.0]) / np.hypot(miss, 1.0)
        np.testing.assert_allclose(R.T @ row.nhat, expected, rtol=0, atol=1e-14)


def test_vertex_into_face():
    """A cube stands on a vertex: the depth is the vertex's, to the last digit."""
    down = np.array([1.0, 1.0, 1.0]) / 3**0.5
    side = np.array([1.0, -1.0, 0.0]) / 2**0.5
    R_WB = np.array([side, np.cross(down, side), down])
    for gap in (1e-3, 1e-6, 0.0, -1e-6, -1e-2):
        row = check(box_box, _boxes([0.1, 0.2, 0.5 + 3**0.5 / 2 + gap], R_WB=R_WB))
        assert row.distance == pytest.approx(gap, abs=5e-16)
        np.testing.assert_allclose(row.p_ACa, [0.1, 0.2, 0.5], rtol=0, atol=2e-15)


def test_depth_is_the_least_translation():
    """Moved by its depth along the normal, B touches A; moved by less, it does not part."""
    rng = np.random.default_rng(9)
    for pair in random_pairs(rng, (2, 2), 3 if config.DISABLE_JIT else 60):
        row = evaluate(box_box, pair)
        for part in (1.0, 0.5):
            moved = moved_apart(pair, pair.b.p + part * row.distance * row.nhat)
            after = evaluate(box_box, moved)
            expected = (1 - part) * row.distance
            assert after.distance == pytest.approx(expected, abs=4 * row.error_bound)


def test_against_the_support_function():
    """The oracle of another making agrees."""
    for pair in random_pairs(np.random.default_rng(12), (2, 2), 2):
        phi, _ = signed_distance(pair.a, pair.b)
        assert evaluate(box_box, pair).distance == pytest.approx(phi, abs=1e-9)


@pytest.mark.parametrize('roundings', [1.25, 2.0, 8.0, 100.0, 1e4])
def test_a_normal_is_unique_only_where_rounding_leaves_it_one(roundings):
    """From corner to corner, so short that no axis is told from the gap."""
    for direction in ([1, 1, 1], [1, 0.5, 0.1], [1, 0.3, 0.3], [0.2, 1, 0.7], [1, 0, 0.9]):
        gap = roundings * 8.0 * np.finfo(float).eps * 3.5 * np.array(direction)
        p_AB_W = 1.0 + gap
        row = evaluate(box_box, _boxes(p_AB_W))
        truth = -(p_AB_W - 1.0) / np.linalg.norm(p_AB_W - 1.0)
        assert not row.unique or row.nhat @ truth > 0.99
        assert row.unique or roundings < 1e3
