"""Time of the support point of a hull: looking at every vertex against climbing along the edges.

    ./run exec python bench/hulls.py

Vertices on a ball, random directions, one thread; nanoseconds, the least of some rounds.
"""

import time

import numpy as np
from numba import njit
from scipy.spatial import ConvexHull

from drake_geom_ros.geometry._proximity import hull_parameters
from drake_geom_ros.geometry._proximity.kernels.hulls import farthest_vertex

COUNTS = (16, 32, 64, 100, 200, 500, 1000, 5000)
DIRECTIONS = 5000
ROUNDS = 9


@njit
def run(shape, ns):
    """Return the sum of the support values along the directions ns (m, 3)."""
    total = 0.0
    for k in range(ns.shape[0]):
        v = farthest_vertex(shape, ns[k, 0], ns[k, 1], ns[k, 2])
        total += v[0] * ns[k, 0] + v[1] * ns[k, 1] + v[2] * ns[k, 2]
    return total


def on_ball(rng, count):
    """Return unit vectors (count, 3)."""
    n = rng.normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=1)[:, None]


def nanoseconds(shape, ns):
    """Return the time of one support point."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        run(shape, ns)
        times.append(time.perf_counter() - start)
    return min(times) / len(ns) * 1e9


def main():
    rng = np.random.default_rng(0)
    ns = on_ball(rng, DIRECTIONS)
    run(np.array([1.0, 0.0, 0.0, 0.0]), ns[:1])
    hull_parameters.CLIMBED = 0
    print(f'{"vertices":>8} {"all":>8} {"climb":>8}   all/climb')
    for count in COUNTS:
        vertices = on_ball(rng, count)
        hull = ConvexHull(vertices)
        turned = np.einsum('ij,ij->i', hull.equations[:, :3], _normals(vertices, hull)) < 0.0
        hull.simplices[turned] = hull.simplices[turned][:, ::-1]
        climbed = hull_parameters.hull_parameters(vertices, hull.simplices.astype(np.int64))
        plain = climbed[: 1 + 3 * count]
        times = nanoseconds(plain, ns), nanoseconds(climbed, ns)
        print(f'{count:8} {times[0]:8.0f} {times[1]:8.0f} {times[0] / times[1]:8.1f}')


def _normals(vertices, hull):
    a, b, c = (vertices[hull.simplices[:, k]] for k in range(3))
    return np.cross(b - a, c - a)


if __name__ == '__main__':
    main()
