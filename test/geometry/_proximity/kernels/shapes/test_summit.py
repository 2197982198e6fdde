"""The farthest point of many, in compiled code too."""

import numpy as np
import pytest
from numba import njit

from drake_geom_ros.geometry._proximity.kernels.shapes.summit import LANES, farthest_index


@njit
def found(numbers, n, x, y, z):
    return farthest_index(numbers, n, x, y, z)


def _packed(points):
    return np.concatenate([[float(len(points))], points.T.ravel()])


@pytest.mark.parametrize('count', [*range(LANES, 3 * LANES + 2), 64, 100, 257])
def test_it_is_the_farthest_wherever_it_stands(count):
    rng = np.random.default_rng(count)
    for _ in range(50):
        points, n = rng.normal(size=(count, 3)), rng.normal(size=3)
        assert found(_packed(points), count, *n) == 1 + np.argmax(points @ n)
    for k in range(count):
        points = np.zeros((count, 3))
        points[k, k % 3] = 1.0
        assert found(_packed(points), count, 1.0, 1.0, 1.0) == 1 + k


@pytest.mark.parametrize('count', [LANES, 2 * LANES + 3, 64])
def test_of_points_that_are_as_far_it_is_the_first(count):
    rng = np.random.default_rng(count)
    for _ in range(100):
        points = rng.integers(-1, 2, (count, 3)).astype(float)
        n = rng.integers(-1, 2, 3).astype(float)
        assert found(_packed(points), count, *n) == 1 + np.argmax(points @ n)
