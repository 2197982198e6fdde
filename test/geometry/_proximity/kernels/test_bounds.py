"""Intervals from bounds alone contain the truth, wherever a hull lies about its origin."""

import numpy as np
import pytest
from oracles.pairs import random_rotation

from drake_geom_ros.evidence.truth.convex import signed_distance
from drake_geom_ros.geometry._proximity.kernels.bounds import Posed, bounding_interval, shape_radii
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    PAIR_WIDTH,
)
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SPHERE


def inner_radius(kind, shape):
    return shape_radii(np.array([kind]), np.array([0, len(shape)]), shape)[1][0]


@pytest.mark.parametrize('beside', [0.0, 0.05, 0.3])
def test_a_hull_beside_its_origin(beside):
    rng = np.random.default_rng(1)
    for _ in range(6):
        vertices = rng.uniform(-0.1, 0.1, (8, 3)) + np.array([beside, 0.0, 0.0])
        hull, ball = np.append(8.0, vertices.ravel()), np.array([0.1])
        R, p = random_rotation(rng), rng.uniform(-0.02, 0.02, 3)
        out = np.zeros(PAIR_WIDTH)
        bounding_interval(
            Posed(SPHERE, ball, np.eye(3), inner_radius(SPHERE, ball)),
            Posed(CONVEX, hull, R, inner_radius(CONVEX, hull)),
            p,
            out,
        )
        poses = (np.eye(3), np.zeros(3)), (R, p)
        phi, _ = signed_distance((SPHERE, ball), poses[0], (CONVEX, hull), poses[1])
        assert abs(out[DISTANCE] - phi) <= out[ERROR_BOUND]
