"""The vertices of a convex hull: which is extreme along a direction, and how far they reach.

The parameters of a hull are the number n of its vertices, 3 n coordinates and its *defect*. Those
of a large one, whose defect is not 0, go on: the vertices extreme along -x, x, -y, y, -z, z, the
places of n + 1 lists, and the lists of the neighbours of each vertex along the edges
(``hull_parameters`` makes them). A vertex is named by the place of its x in the parameters.

A large hull is climbed, from neighbour to neighbour, for as long as that leads farther along the
direction: on a convex polytope there is no other summit. At a vertex that is almost flat rounding
may hide the way on; its list has a negative place, and all vertices are looked at instead. The
defect [m] is by how much the vertex found elsewhere may fall short of the true one.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.kinds import VERTEX_COUNT
from drake_geom_ros.geometry._proximity.tolerances import LARGE_SQUARE, SMALL_SQUARE

DEFECT = 1  # places after the coordinates: the defect, six summits, the lists
SUMMITS = 2
LISTS = 8


@inlined
def hull_defect(shape):
    """Return how far [m] the vertices of ``farthest_vertex`` may fall short of the true ones."""
    end = 3 * int(shape[VERTEX_COUNT])
    return shape[end + DEFECT] if shape.size > end + DEFECT else 0.0


@inlined
def _farthest_of_all(shape, x, y, z):
    """Return the place of the vertex that is extreme along (x, y, z)."""
    # Unsigned numbers: the test for negative ones would double the time.
    best = np.uint64(1)
    value = shape[1] * x + shape[2] * y + shape[3] * z
    for k in range(np.uint64(4), np.uint64(3 * int(shape[VERTEX_COUNT]) + 1), np.uint64(3)):
        candidate = shape[k] * x + shape[k + np.uint64(1)] * y + shape[k + np.uint64(2)] * z
        if candidate > value:
            value = candidate
            best = k
    return np.int64(best)


@inlined
def _summit(shape, end, x, y, z):
    """Return the vertex that is extreme along the axis nearest to (x, y, z)."""
    along, value = 0, x
    if abs(y) > abs(value):
        along, value = 2, y
    if abs(z) > abs(value):
        along, value = 4, z
    return int(shape[end + SUMMITS + along + (1 if value > 0.0 else 0)])


@compiled
def _climbed(shape, end, x, y, z):
    """Return the place of the vertex that is extreme along (x, y, z), up to the defect."""
    here = _summit(shape, end, x, y, z)
    # The path visits no vertex twice, for each is farther than the one before.
    for _ in range(int(shape[VERTEX_COUNT])):
        place = end + LISTS + (here - 1) // 3
        first, last = int(shape[place]), int(abs(shape[place + 1]))
        if first < 0:
            return _farthest_of_all(shape, x, y, z)
        p, q, r = shape[here], shape[here + 1], shape[here + 2]
        best, gain = here, 0.0
        for k in range(first, last):
            u = int(shape[k])
            # Differences of neighbours: what rounding hides is relative to the edge.
            d = (shape[u] - p) * x + (shape[u + 1] - q) * y + (shape[u + 2] - r) * z
            if d > gain:
                best, gain = u, d
        if best == here:
            break
        here = best
    return here


@inlined
def _farthest(shape, x, y, z):
    """Return the place of the vertex that is extreme along the unit vector (x, y, z)."""
    if hull_defect(shape) > 0.0:
        return _climbed(shape, 3 * int(shape[VERTEX_COUNT]), x, y, z)
    return _farthest_of_all(shape, x, y, z)


@compiled
def farthest_vertex(shape, x, y, z):
    """Return the vertex of a hull that is extreme along the unit vector (x, y, z)."""
    k = _farthest(shape, x, y, z)
    return shape[k], shape[k + 1], shape[k + 2]


@inlined
def _edge_slope(shape, here, k, x, y, z):
    """Return the squared slope of the line from one vertex to another, and its squared length.

    It is the fall along (x, y, z), times the length: who compares slopes needs no square root.
    """
    one, here, k = np.uint64(1), np.uint64(here), np.uint64(k)
    u, v, w = (
        shape[k] - shape[here],
        shape[k + one] - shape[here + one],
        shape[k + one + one] - shape[here + one + one],
    )
    fall = min(u * x + v * y + w * z, 0.0)
    return fall * fall, u * u + v * v + w * w


@compiled
def farthest_edge(shape, x, y, z):
    """Return the vertex of a hull extreme along the unit (x, y, z), and another.

    The line to the other falls away from the direction with the least slope: it is an edge of the
    hull, and where a turn of the direction brings another vertex to the fore, the first one. So
    only neighbours are looked at where they are listed.
    """
    here = _farthest(shape, x, y, z)
    end = 3 * int(shape[VERTEX_COUNT])
    other, least = here, math.inf
    place, listed = 0, hull_defect(shape) > 0.0
    if listed:
        place = end + LISTS + (here - 1) // 3
        listed = shape[place] >= 0.0
    if listed:
        for k in range(int(shape[place]), int(abs(shape[place + 1]))):
            u = int(shape[k])
            fall, length = _edge_slope(shape, here, u, x, y, z)
            if length > 0.0 and fall < least * length:
                other, least = u, fall / length
    else:
        for k in range(1, end + 1, 3):
            fall, length = _edge_slope(shape, here, k, x, y, z)
            if length > 0.0 and fall < least * length:
                other, least = k, fall / length
    return (
        (shape[here], shape[here + 1], shape[here + 2]),
        (shape[other], shape[other + 1], shape[other + 2]),
    )


@compiled
def hull_radius(shape):
    """Return the largest distance [m] of a vertex from Go."""
    farthest, one = 0.0, np.uint64(1)
    for k in range(one, np.uint64(3 * int(shape[VERTEX_COUNT]) + 1), np.uint64(3)):
        x, y, z = shape[k], shape[k + one], shape[k + np.uint64(2)]
        farthest = max(farthest, x * x + y * y + z * z)
    if SMALL_SQUARE < farthest < LARGE_SQUARE:
        return math.sqrt(farthest)
    farthest = 0.0
    for k in range(1, 3 * int(shape[VERTEX_COUNT]) + 1, 3):
        farthest = max(farthest, norm((shape[k], shape[k + 1], shape[k + 2])))
    return farthest
