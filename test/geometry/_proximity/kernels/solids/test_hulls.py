"""Ways out of the hulls of two solids, against all that are tried."""

import numpy as np
import pytest
from oracles.forms import kernel_form
from oracles.solids import solid

from drake_geom_ros.geometry._proximity.kernels.solids import hulls
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    SolidPair,
    body_of,
    normal_of,
    solid_of,
)
from drake_geom_ros.geometry._proximity.kinds import BOX, CONVEX, SOLID
from truth.bodies.random_bodies import random_rotation

L = kernel_form(solid('L'))[1]


def _corners(body, j):
    at = body.tree.corners + 9 * j
    return body.shape[at : at + 9].reshape(3, 3)


@pytest.mark.parametrize('seed', range(4))
def test_the_way_out_of_the_hulls_is_the_shortest_that_is_tried(seed):
    rng = np.random.default_rng(seed)
    R, p = random_rotation(rng), tuple(rng.uniform(0.0, 1.0, 3))
    A, B = body_of(SOLID, L, R), solid_of(L)
    m, s = hulls.separating_move_of_hulls(SolidPair(A, B, p, 4.0, 1e-9, 0.0))
    assert np.linalg.norm(m) == pytest.approx(1.0, abs=1e-14)
    mine = np.vstack([_corners(A, j) for j in range(A.tree.triangles)]) @ R.T + p
    its = np.vstack([_corners(B, j) for j in range(B.tree.triangles)])

    def width(n):
        return (its @ n).max() - (mine @ n).min()

    assert width(np.array(m)) == pytest.approx(s, abs=1e-14)
    normals = [np.array(normal_of(L, B.tree, j)) for j in range(B.tree.triangles)]
    tried = [*normals, *(-R @ n for n in normals), *R.T, *-R.T]
    # The hull of the L has one face more, across its notch.
    tried += [np.array([0.5**0.5, 0.5**0.5, 0.0]), -R @ [0.5**0.5, 0.5**0.5, 0.0]]
    assert s == pytest.approx(min(width(n) for n in tried), abs=1e-14)


def test_the_middle_of_a_hull_is_the_mean_of_its_vertices_and_of_others_their_origin():
    rng = np.random.default_rng(5)
    R, p, vertices = random_rotation(rng), (1.0, 2.0, 3.0), rng.uniform(4.0, 5.0, (7, 3))
    hull = body_of(CONVEX, np.concatenate(([7.0], vertices.T.ravel(), [0.0])), R)
    expected = p + R @ vertices.mean(axis=0)
    assert hulls.middle_of(hull, p) == pytest.approx(expected, abs=1e-14)
    assert hulls.middle_of(body_of(BOX, np.ones(3), R), p) == p
