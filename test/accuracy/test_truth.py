"""The truth against distances that need no oracle."""

import numpy as np
import pytest
from oracles.pairs import random_pairs, random_rotation

from drake_geom_ros.accuracy.supports import (
    BOX,
    CAPSULE,
    CONVEX,
    CYLINDER,
    ELLIPSOID,
    HALF_SPACE,
    SPHERE,
)
from drake_geom_ros.accuracy.truth import signed_distance

CORNERS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


@pytest.mark.parametrize(
    ('a', 'b', 'p', 'truth'),
    [
        ((SPHERE, [1]), (SPHERE, [2]), (3, 4, 0), 2),
        ((SPHERE, [1]), (SPHERE, [2]), (0, 0, 0), -3),
        ((BOX, [0.5] * 3), (BOX, [0.5] * 3), (0, 4, 0), 3),
        ((BOX, [0.5] * 3), (BOX, [0.5] * 3), (2, 2, 2), 3**0.5),
        ((BOX, [0.5] * 3), (CYLINDER, [0.25, 0.5]), (0, 0, 0.9), -0.1),
        ((CAPSULE, [0.1, 0.5]), (CAPSULE, [0.2, 0.5]), (0.5, 0, 0.3), 0.2),
        ((CYLINDER, [0.25, 0.5]), (CYLINDER, [0.25, 0.5]), (0, 0, 0), -0.5),
        ((CYLINDER, [1, 1]), (CYLINDER, [1, 1]), (5, 0, 6), 5),
        ((ELLIPSOID, [1, 1, 1e-3]), (ELLIPSOID, [1, 1, 1e-3]), (0, 0, 0), -2e-3),
        ((ELLIPSOID, [0.3, 0.2, 0.1]), (SPHERE, [0.1]), (0.5, 0, 0), 0.1),
        ((ELLIPSOID, [0.3, 0.2, 0.1]), (HALF_SPACE, []), (0, 0, -0.05), -0.05),
    ],
)
def test_distances_known_by_hand(a, b, p, truth):
    R = random_rotation(np.random.default_rng(1))
    phi, n = signed_distance(a, (R, np.zeros(3)), b, (R, R @ np.array(p, dtype=float)))
    assert phi == pytest.approx(truth, abs=1e-12)
    assert np.linalg.norm(n) == pytest.approx(1, abs=1e-12)
    back, _ = signed_distance(b, (R, R @ np.array(p, dtype=float)), a, (R, np.zeros(3)))
    assert back == pytest.approx(truth, abs=1e-12)


def test_a_box_is_the_hull_of_its_corners():
    for pair in random_pairs(np.random.default_rng(2), (BOX, CYLINDER), 6):
        poses = (pair.R_WA, np.zeros(3)), (pair.R_WB, pair.p_AB_W)
        box, hull = (
            signed_distance(shape, poses[0], (CYLINDER, pair.size_B), poses[1])[0]
            for shape in (
                (BOX, pair.size_A),
                (CONVEX, np.append(8, (CORNERS * pair.size_A).ravel())),
            )
        )
        assert box == pytest.approx(hull, abs=1e-12)


def test_the_closed_forms_agree():
    for pair in random_pairs(np.random.default_rng(3), (BOX, BOX), 6):
        phi, _ = signed_distance(
            (BOX, pair.size_A), (pair.R_WA, np.zeros(3)),
            (BOX, pair.size_B), (pair.R_WB, pair.p_AB_W),
        )  # fmt: skip
        assert phi == pytest.approx(pair.truth(), abs=1e-11)
