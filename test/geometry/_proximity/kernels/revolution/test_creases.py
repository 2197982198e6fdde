"""Depth over faces and creases, against the support-function oracle."""

import numpy as np
import pytest
from numba import config
from oracles.case_laws import radius_of_core
from oracles.core_pairs import core_pair
from oracles.pairs import random_pairs
from scipy.spatial.transform import Rotation

from drake_geom_ros.geometry._proximity.kernels.convex import depths
from drake_geom_ros.geometry._proximity.kernels.cores import normals, sums
from drake_geom_ros.geometry._proximity.kernels.revolution import creases
from drake_geom_ros.geometry._proximity.kinds import BOX, CAPSULE, CYLINDER
from truth.bodies.random_bodies import random_rotation
from truth.references.convex import signed_distance

COUNT = 6 if config.DISABLE_JIT else 24
NOISE = 1e-15


def _least_from(difference, n, enough, noise):
    """Return the least h, and the same from the minimum that is next to n."""
    found = creases.least_on_creases(difference, normals.nowhere(n), enough, noise)
    newton = normals.nearby_minimum(difference, n, noise)
    other = creases.least_on_creases(difference, newton, enough, noise)
    assert other.complete == found.complete
    assert other.h == pytest.approx(found.h, abs=enough + 4 * noise)
    return found


def _least(pair, start=(1.0, 0.0, 0.0)):
    pair = core_pair(*pair.a.form, pair.a.R, *pair.b.form, pair.b.R, pair.b.p)
    return _least_from(sums.difference_of(pair), start, 1e-12, NOISE)


@pytest.mark.parametrize('kind', [BOX, CAPSULE])
def test_overlapping_cores_are_as_deep_as_the_oracle_says(kind):
    rng, seen = np.random.default_rng(3), 0
    for pair in random_pairs(rng, (kind, CYLINDER), COUNT):
        phi, _ = signed_distance(pair.a, pair.b)
        radius = radius_of_core(pair.a)
        if phi + radius < -1e-6:
            complete, h, floor, n, _ = _least(pair)
            assert h - 1e-12 <= floor <= h
            assert complete
            assert h == pytest.approx(-phi - radius, abs=1e-12)
            assert np.linalg.norm(n) == pytest.approx(1, abs=1e-14)
            seen += 1
    assert seen >= 2


def test_the_start_does_not_matter():
    rng = np.random.default_rng(4)
    for pair in random_pairs(rng, (BOX, CYLINDER), COUNT):
        found = [_least(pair, tuple(n))[1] for n in np.vstack([np.eye(3), -np.eye(3)])]
        if min(found) > 0:
            assert max(found) - min(found) <= 1e-14


def test_planes_that_no_search_chose_are_looked_at_too():
    """As ``depths.guarded`` does with other searches' floors: here it would change nothing."""
    rng = np.random.default_rng(5)
    for pair in random_pairs(rng, (BOX, CYLINDER), COUNT):
        found = _least(pair)
        difference = sums.difference_of(
            core_pair(*pair.a.form, pair.a.R, *pair.b.form, pair.b.R, pair.b.p)
        )
        assert depths.guarded(difference, found.floor, NOISE) == found.floor


@pytest.mark.parametrize(
    ('p', 'depth', 'unique'),
    [((0.4, 0.0, 0.0), 0.35, True), ((0.4, 0.4, 0.0), 0.35, False), ((0.0, 0.0, 0.7), 0.8, False)],
)
def test_a_rod_through_a_cube(p, depth, unique):
    pair = core_pair(BOX, [0.5, 0.5, 0.5], np.eye(3), CYLINDER, [0.25, 1.0], np.eye(3), p)
    difference = sums.difference_of(pair)
    complete, h, _, _, is_unique = _least_from(difference, (0.0, 0.0, 1.0), 1e-9, NOISE)
    assert complete
    assert h == pytest.approx(min(depth, 0.75), abs=1e-15)
    assert is_unique == unique


@pytest.mark.parametrize('swap', [1.0, -1.0])
def test_a_stuck_peg(swap):
    # Issue 12: the plane n proves a depth of at most 0.416, and 0.5 was reported within 4e-15.
    R = np.array([[-1, 0, 0], [0, -0.6, 0.8], [0, 0.8, 0.6]])
    p = swap * np.array([0, 0.008, 0.006])
    pair = core_pair(CAPSULE, [0.25, 0.5], R, CYLINDER, [0.25, 0.02], np.eye(3), p)
    for start in np.vstack([np.eye(3), -np.eye(3)]):
        complete, h, floor, n, _ = _least_from(
            sums.difference_of(pair), tuple(start), 1e-10, NOISE
        )
        assert complete
        # The plane (0, 0.6, -0.8): 0.25 * 0.6 + 0.02 * 0.8, beside the capsule's radius.
        width = 0.25 * 0.6 + 0.02 * 0.8
        assert h == pytest.approx(width, abs=1e-15)
        assert h - 1e-10 <= floor <= h
        assert abs(np.dot(n, [0, 0.6, -0.8])) == pytest.approx(1, abs=1e-12)


def test_an_end_of_a_box_almost_on_the_face_of_a_cylinder():
    """The disk is seen from its edge but for 1e-7 rad: its largest radius of curvature is 1e6 m.

    The hunt found a floor that was too high by as much as the tolerance.
    """
    half, size = np.array([0.00925, 0.0288, 0.1135]), np.array([0.2, 0.105])
    turn = Rotation.from_rotvec([-5.28616132e-06, 1.11837431e-07, 1.26330826e-05]).as_matrix()
    p = np.array([0.19027249075435002, 0.00031700308020106665, 0.21838790893999357])
    least = []
    rng = np.random.default_rng(0)
    for _ in range(4 * COUNT):
        R = random_rotation(rng)
        pair = core_pair(BOX, half, R @ turn, CYLINDER, size, R, R @ p)
        difference = sums.difference_of(pair)
        for start in rng.normal(size=(5, 3)):
            n = tuple(start / np.linalg.norm(start))
            least.append(_least_from(difference, n, 1.17e-11, 1.6e-15))
    least_h = min(found.h for found in least)
    for found in least:
        assert found.complete
        assert found.floor <= least_h + 4e-15
        assert found.h <= least_h + 1.3e-11


@pytest.mark.parametrize('kinds', [(BOX, CYLINDER), (CYLINDER, BOX), (CAPSULE, CYLINDER)])
@pytest.mark.parametrize('turn', range(3))
def test_cores_reach_so_far_across_a_segment(kinds, turn):
    """Each for itself, along the direction in which it reaches least: by dense directions."""
    sizes = {
        BOX: np.roll([0.2, 0.4, 0.5], turn),
        CAPSULE: np.array([0.1, 0.6]),
        CYLINDER: np.roll([0.3, 0.7], turn),
    }
    pair = core_pair(
        *((kinds[0], sizes[kinds[0]], np.eye(3))),
        *((kinds[1], sizes[kinds[1]], np.eye(3))),
        np.zeros(3),
    )
    terms, first, last, _, _ = sums.difference_of(pair)
    angles = np.radians(np.arange(0.0, 360.0, 1.0))
    for i in range(sums.SEGMENT, last):
        axis = int(np.argmax(np.abs(terms[i, :3])))
        n = np.zeros((len(angles), 3))
        n[:, axis - 1], n[:, axis - 2] = np.cos(angles), np.sin(angles)
        for low, high, axes in ((sums.SEGMENT, first, sums.AXES_A), (first, last, sums.AXES_B)):
            reach = np.abs(n @ terms[low:high, :3].T).sum(axis=1)
            reach += np.linalg.norm(n @ terms[axes : axes + 3, :3].T, axis=1)
            found = creases.reach_across(terms, low, high, axes, i)
            assert found <= reach.min() + 1e-15
            assert found == pytest.approx(reach.min(), abs=1e-15) or not low <= i < high
