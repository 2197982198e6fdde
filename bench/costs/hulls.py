"""Time of the support point of a hull: looking at every vertex against climbing along the edges.

    ./run exec python bench/costs/hulls.py

Vertices on a ball, random directions, one thread; nanoseconds, the least of some rounds.
"""

import time

import numpy as np
from numba import njit

from drake_geom_ros.geometry import Convex, MeshData
from drake_geom_ros.geometry._proximity.kernels.shapes import hull_packing as hull_parameters
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import farthest_vertex
from truth.bodies.random_bodies import random_directions

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
    ns = random_directions(rng, DIRECTIONS)
    run(np.array([1.0, 0.0, 0.0, 0.0]), ns[:1])
    hull_parameters.CLIMBED = 0
    print(f'{"vertices":>8} {"all":>8} {"climb":>8}   all/climb')
    for count in COUNTS:
        vertices = random_directions(rng, count)
        surface = Convex.FromMeshData(MeshData(vertices)).hull_surface()
        climbed = hull_parameters.hull_parameters(*surface)
        plain = climbed[: 1 + 3 * count]
        times = nanoseconds(plain, ns), nanoseconds(climbed, ns)
        print(f'{count:8} {times[0]:8.0f} {times[1]:8.0f} {times[0] / times[1]:8.1f}')


if __name__ == '__main__':
    main()
