"""Support vertices and radii of convex hulls.

The parameters of a hull are the number n of its vertices, their n x, n y and n z, its *defect*,
the centre and radius of an inner ball, its radius about Go, and where its *coarse hull* begins, 0
for none. A large hull, with a defect other than 0, also has the vertices extreme along -x, x, -y,
y, -z, z, the starts of n + 1 lists, and the lists of the neighbours of each vertex along the edges
(made by ``hull_parameters``). A vertex is identified by the index of its x, 1 to n. Vertices alone
are a valid hull without a ball.

A coarse hull is the hull of some of the vertices. Its *reach* [m], no less than the distance of
any point of the hull from it, comes first, then its own parameters.

All vertices of a small hull are scanned, several at a time (``summit``).

A large hull is searched by hill climbing from neighbour to neighbour: a convex polytope has no
other local maximum. At an almost flat vertex rounding may hide the way on; the start of its list
is negative, and all vertices are scanned instead. The defect [m] bounds how far the vertex found
elsewhere may fall short of the true one.
"""

import math

from drake_geom_ros.geometry._proximity.kernels.shapes.summit import farthest_index
from drake_geom_ros.geometry._proximity.kernels.vectors import dot, norm, sub
from drake_geom_ros.geometry._proximity.kinds import VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector, signed, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import LARGE_SQUARE, SMALL_SQUARE

# Offsets after the coordinates.
DEFECT = 1
BALL = 2  # 4: centre and radius
RADIUS = 6
COARSE_HULL = 7  # 0, or where it begins
EXTREMES = 8  # 6: vertices extreme along the axes
LISTS = 14
# Vertices from which on the vectorised scan is faster.
SEVERAL = 32


@inlined
def hull_defect(shape: Floats) -> float:
    """Return how far [m] the vertices of ``farthest_vertex`` may fall short of the true ones."""
    end = 3 * int(shape[VERTEX_COUNT])
    return shape[end + DEFECT] if shape.size > end + DEFECT else 0.0


@inlined
def ball_in_hull(shape: Floats) -> tuple[Vector, float]:
    """Return (centre, radius) [m] of a ball in a hull; the radius is 0 if unknown."""
    place = 3 * int(shape[VERTEX_COUNT]) + BALL
    if shape.size <= place + 3:
        return (0.0, 0.0, 0.0), 0.0
    return (shape[place], shape[place + 1], shape[place + 2]), shape[place + 3]


@inlined
def coarse_hull_at(shape: Floats) -> int:
    """Return where the coarse hull of a hull begins in its parameters, its reach; 0 for none."""
    place = 3 * int(shape[VERTEX_COUNT]) + COARSE_HULL
    return int(shape[place]) if shape.size > place else 0


@inlined
def end_of_header(shape: Floats, first: int) -> int:
    """Return the end of the vertices and the header of the hull that begins at an index."""
    return first + 3 * int(shape[first + VERTEX_COUNT]) + COARSE_HULL + 1


@inlined
def vertex_at(shape: Floats, k: int) -> Vector:
    """Return vertex k of a hull, 1 to n."""
    # Unsigned indices: the test for negative ones would double the time of a loop.
    n, k = _count(shape), unsigned(k)
    return shape[k], shape[k + n], shape[k + n + n]


@inlined
def _count(shape: Floats) -> int:
    return unsigned(int(shape[VERTEX_COUNT]))


@inlined
def _along(shape: Floats, n: int, k: int, x: float, y: float, z: float) -> float:
    """Return the offset of vertex k of n along (x, y, z)."""
    return shape[k] * x + shape[k + n] * y + shape[k + n + n] * z


@inlined
def _farthest_of_few(shape: Floats, n: int, x: float, y: float, z: float) -> int:
    """Return the first of n vertices extreme along (x, y, z), one by one."""
    first = unsigned(1)
    best, value = first, _along(shape, n, first, x, y, z)
    for k in range(unsigned(2), n + first):
        candidate = _along(shape, n, k, x, y, z)
        if candidate > value:
            best, value = k, candidate
    return signed(best)


@compiled
def _farthest_of_all(shape: Floats, x: float, y: float, z: float) -> int:
    """Return the first vertex extreme along (x, y, z), by a scan."""
    n = _count(shape)
    if n < SEVERAL:
        return _farthest_of_few(shape, n, x, y, z)
    return farthest_index(shape, signed(n), x, y, z)


@inlined
def _first_vertex(shape: Floats, end: int, x: float, y: float, z: float) -> int:
    """Return the vertex extreme along the axis nearest to (x, y, z), where climbing starts."""
    along, value = 0, x
    if abs(y) > abs(value):
        along, value = 2, y
    if abs(z) > abs(value):
        along, value = 4, z
    return int(shape[end + EXTREMES + along + (1 if value > 0.0 else 0)])


@compiled
def _climbed(shape: Floats, end: int, x: float, y: float, z: float) -> int:
    """Return the index of the vertex extreme along (x, y, z), within the defect, by climbing."""
    here = _first_vertex(shape, end, x, y, z)
    # The path visits no vertex twice, because each is farther than the previous one.
    for _ in range(int(shape[VERTEX_COUNT])):
        place = end + LISTS + here - 1
        first, last = int(shape[place]), int(abs(shape[place + 1]))
        if first < 0:
            return _farthest_of_all(shape, x, y, z)
        p, best, gain = vertex_at(shape, here), here, 0.0
        for k in range(first, last):
            u = int(shape[k])
            # From differences of neighbours, so rounding is relative to the edge.
            d = dot(sub(vertex_at(shape, u), p), (x, y, z))
            if d > gain:
                best, gain = u, d
        if best == here:
            break
        here = best
    return here


@inlined
def farthest(shape: Floats, x: float, y: float, z: float) -> int:
    """Return the index of the vertex extreme along the unit vector (x, y, z)."""
    if hull_defect(shape) > 0.0:
        return _climbed(shape, 3 * int(shape[VERTEX_COUNT]), x, y, z)
    return _farthest_of_all(shape, x, y, z)


@compiled
def farthest_vertex(shape: Floats, x: float, y: float, z: float) -> Vector:
    """Return the vertex of a hull extreme along the unit vector (x, y, z)."""
    return vertex_at(shape, farthest(shape, x, y, z))


@inlined
def _slope(shape: Floats, here: int, k: int, x: float, y: float, z: float) -> float:
    """Return the squared slope of the line from vertex ``here`` to k; infinite for equal ones.

    The slope is the descent along (x, y, z); squaring avoids a square root.
    """
    u, v, w = sub(vertex_at(shape, k), vertex_at(shape, here))
    fall, length = max(-(u * x + v * y + w * z), 0.0), u * u + v * v + w * w
    return fall * fall / length if length > 0.0 else math.inf


@inlined
def _least_slope(shape: Floats, here: int, x: float, y: float, z: float) -> int:
    """Return the vertex to which the line from vertex ``here`` has the least slope."""
    n, first = _count(shape), unsigned(1)
    steepest = -math.inf  # of negated slopes, so that ``max`` applies
    for k in range(first, n + first):
        steepest = max(-_slope(shape, here, k, x, y, z), steepest)
    best = n
    for k in range(first, n + first):
        best = min(best, k if -_slope(shape, here, k, x, y, z) == steepest else n)
    return signed(best)


@compiled
def farthest_edge(shape: Floats, x: float, y: float, z: float) -> tuple[Vector, Vector]:
    """Return the edge of a hull at the vertex extreme along the unit (x, y, z).

    The line from the extreme vertex to the other one has the least slope, so it is an edge of the
    hull, and the first that becomes extreme as the direction turns. Only listed neighbours are
    examined, if there are lists.
    """
    here = farthest(shape, x, y, z)
    end = 3 * int(shape[VERTEX_COUNT])
    place, listed = end + LISTS + here - 1, hull_defect(shape) > 0.0
    if not listed or shape[place] < 0.0:
        return vertex_at(shape, here), vertex_at(shape, _least_slope(shape, here, x, y, z))
    other, least = here, math.inf
    for k in range(int(shape[place]), int(abs(shape[place + 1]))):
        u = int(shape[k])
        slope = _slope(shape, here, u, x, y, z)
        if slope < least:
            other, least = u, slope
    return vertex_at(shape, here), vertex_at(shape, other)


@compiled
def hull_radius(shape: Floats) -> float:
    """Return the largest distance [m] of a vertex from Go."""
    place = 3 * int(shape[VERTEX_COUNT]) + RADIUS
    if shape.size > place:
        return shape[place]
    n, farthest = _count(shape), 0.0
    for k in range(unsigned(1), n + unsigned(1)):
        x, y, z = shape[k], shape[k + n], shape[k + n + n]
        farthest = max(x * x + y * y + z * z, farthest)
    if SMALL_SQUARE < farthest < LARGE_SQUARE:
        return math.sqrt(farthest)
    farthest = 0.0
    for k in range(1, int(n) + 1):
        farthest = max(farthest, norm(vertex_at(shape, k)))
    return farthest


@compiled
def farthest_along_axes(shape: Floats, R: Floats) -> Vector:
    """Return the largest absolute offsets [m] of the vertices along the rows of R (3, 3)."""
    along_x, along_y, along_z = 0.0, 0.0, 0.0
    for k in range(unsigned(1), _count(shape) + unsigned(1)):
        x, y, z = vertex_at(shape, k)
        along_x = max(abs(R[0, 0] * x + R[0, 1] * y + R[0, 2] * z), along_x)
        along_y = max(abs(R[1, 0] * x + R[1, 1] * y + R[1, 2] * z), along_y)
        along_z = max(abs(R[2, 0] * x + R[2, 1] * y + R[2, 2] * z), along_z)
    return along_x, along_y, along_z
