"""A polytope of few vertices: all its triangles are looked at in each step, and none is linked.

Two hulls take 10 to 25 vertices. Links, a heap and dead faces (``polytope``) then cost more than
they save (a depth of two hulls: 1.4 times as long). Here loops over all faces, several at a time,
tell which is nearest and which see a vertex; these are taken out, and the last faces fill their
places. An edge of such a face is on the horizon where none of
them has it the other way round. For that, the ends of the edges from a vertex are the bits of a
number: no polytope has more vertices than MOST_GROWN.

``corners`` has three rows of numbers, one a face, of its vertices, counter-clockwise seen from
outside. ``planes`` has rows for the unit normals out of the polytope, for the least offset of the
vertices along them, and for the *key*: the offset again, or infinite where a face need not be
looked at; what follows is scratch. Their rows are parts of flat arrays, MOST_ROWS long (``at``):
LLVM then knows that they do not overlap, and makes one operation of those for several faces.
Vertices are the rows of ``gjk.put``, with a name at the end.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.polytope import plane_of
from drake_geom_ros.geometry._proximity.kernels.shapes.summit import LANES
from drake_geom_ros.geometry._proximity.kernels.vectors import cross, dot, scale, sub, vector_in
from drake_geom_ros.geometry._proximity.runtime.arrays import (
    Floats,
    Indices,
    Integers32,
    Vector,
    signed,
    unsigned,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.larger import larger
from drake_geom_ros.geometry._proximity.runtime.views import (
    integers,
    part,
    table,
    wide_integers,
)
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    LARGE_SQUARE,
    SMALL_SQUARE,
)

# Vertices that a polytope may grow to; most take 10 to 25. Faces are 2 n - 4, but for surfaces
# that are recalled, which may be several.
MOST_GROWN = 40
MOST_ROWS = 96  # LANES of them are for what is not looked at
POINT_WIDTH = 10
NAME = 9  # column of the points
OFFSET, KEY = 3, 4  # rows of the planes, after the normal
PLANE_ROWS = 5
ABOVE = 5  # rows of scratch: how far a vertex is above a face
PLACES = 6  # 9: x, y and z of the corners
MOST_EDGES = 3 * MOST_ROWS + 1


@inlined
def growth_numbers() -> int:
    """Return how many numbers a polytope needs to grow in."""
    return (POINT_WIDTH + 2) * MOST_GROWN + (PLACES + 9) * MOST_ROWS + 2 * MOST_ROWS + MOST_EDGES


@allocating
def growth_arrays(
    block: Floats,
) -> tuple[Floats, Integers32, Floats, Indices, Integers32, Integers32]:
    """Return what a polytope grows in: (points, corners, planes, masks, seen, horizon).

    All are views of a block of ``growth_numbers``; the last three are scratch.
    """
    numbers = POINT_WIDTH * MOST_GROWN
    end = numbers + (PLACES + 9) * MOST_ROWS
    rest = integers(block, end + 2 * MOST_GROWN)
    return (
        table(block, 0, MOST_GROWN, POINT_WIDTH),
        part(rest, 0, 3 * MOST_ROWS),
        part(block, numbers, end),
        part(wide_integers(block, end), 0, 2 * MOST_GROWN),
        part(rest, 3 * MOST_ROWS, 4 * MOST_ROWS),
        part(rest, 4 * MOST_ROWS, 4 * MOST_ROWS + 2 * MOST_EDGES),
    )


@inlined
def at(row: int, f: int) -> int:
    """Return the place of face f in a row of corners or planes."""
    return unsigned(row * MOST_ROWS) + unsigned(f)


@inlined
def corner(points: Floats, corners: Integers32, k: int, f: int) -> Vector:
    """Return corner k of face f."""
    return vector_in(points, corners[at(k, f)])


@inlined
def normal_of(planes: Floats, f: int) -> Vector:
    """Return the unit normal of face f."""
    return planes[at(0, f)], planes[at(1, f)], planes[at(2, f)]


@inlined
def set_corners(corners: Integers32, f: int, i: int, j: int, k: int) -> None:
    """Make face f that of the vertices i, j and k."""
    corners[at(0, f)], corners[at(1, f)], corners[at(2, f)] = i, j, k


@inlined
def place_of(planes: Floats, row: int, f: int) -> Vector:
    """Return the three numbers of scratch of a face that begin in a row."""
    return planes[at(row, f)], planes[at(row + 1, f)], planes[at(row + 2, f)]


@inlined
def set_plane(planes: Floats, f: int, n: Vector, offset: float) -> None:
    """Set the plane and the key of face f."""
    planes[at(0, f)], planes[at(1, f)], planes[at(2, f)] = n
    planes[at(OFFSET, f)], planes[at(KEY, f)] = offset, offset


@inlined
def set_planes(
    points: Floats, corners: Integers32, planes: Floats, first: int, total: int, size: float
) -> None:
    """Set the planes and keys of the faces from first to total.

    What ``polytope.set_planes`` does: a loop without choices, and ``plane_of`` for the faces that
    would lose digits so. Corners are put side by side, and the faces are made a multiple of LANES:
    then all is done for LANES of them at a time (what comes out of the rows beyond the last face,
    whatever these hold, nobody looks at).
    """
    for f in range(unsigned(first), unsigned(total)):
        for k in range(3):
            v = unsigned(corners[at(k, f)])
            for axis in range(3):
                planes[at(PLACES + 3 * k + axis, f)] = points[v, axis]
    whole = unsigned((total - first + LANES - 1) // LANES * LANES)
    for f in range(unsigned(first), unsigned(first) + whole):
        a, b, c = (
            place_of(planes, PLACES, f),
            place_of(planes, PLACES + 3, f),
            place_of(planes, PLACES + 6, f),
        )
        n = cross(sub(b, a), sub(c, b))
        squared = dot(n, n)
        usual = (squared > SMALL_SQUARE) & (squared < LARGE_SQUARE)
        n = scale(1.0 / math.sqrt(squared if usual else 1.0), n)
        x, y, z = dot(n, a), dot(n, b), dot(n, c)
        highest = larger(larger(x, y), z)
        offset = -larger(larger(-x, -y), -z)
        usual = usual & (highest - offset <= COPLANAR * EPS * size)
        set_plane(planes, f, n, offset if usual else np.inf)
    unset = 0
    for f in range(unsigned(first), unsigned(total)):
        unset |= 1 if planes[at(OFFSET, f)] == np.inf else 0
    if unset != 0:
        set_slivers(points, corners, planes, first, total, size)


@compiled
def set_slivers(
    points: Floats, corners: Integers32, planes: Floats, first: int, total: int, size: float
) -> None:
    """Set the planes that ``set_planes`` left out."""
    for f in range(unsigned(first), unsigned(total)):
        if planes[at(OFFSET, f)] == np.inf:
            n, offset = plane_of(
                corner(points, corners, 0, f),
                corner(points, corners, 1, f),
                corner(points, corners, 2, f),
                size,
            )
            set_plane(planes, f, n, offset)


@inlined
def nearest(planes: Floats, total: int) -> int:
    """Return the first of the faces whose key is least; the number of faces if that is 0."""
    end, least = unsigned(total), -np.inf  # of the keys' opposites, for the sake of ``larger``
    for f in range(unsigned(0), end):
        least = larger(-planes[at(KEY, f)], least)
    best = end
    for f in range(unsigned(0), end):
        best = min(best, f if -planes[at(KEY, f)] == least else end)
    return signed(best)


@inlined
def faces_that_see(
    planes: Floats, total: int, w: Vector, thickness: float, seen: Integers32
) -> int:
    """List the faces that see w, which is more than ``thickness`` [m] above them; return how many.

    Faces in one plane with w would else be taken out as rounding falls.
    """
    for f in range(unsigned(total)):
        m = planes[at(0, f)], planes[at(1, f)], planes[at(2, f)]
        planes[at(ABOVE, f)] = dot(m, w) - planes[at(OFFSET, f)]
    count = 0
    for f in range(unsigned(total)):
        seen[unsigned(count)] = f
        count += 1 if planes[at(ABOVE, f)] > thickness else 0
    return count


@inlined
def horizon_of(
    corners: Integers32, seen: Integers32, count: int, masks: Indices, horizon: Integers32
) -> int:
    """Fill in the edges around ``count`` faces that are listed; return how many, or 0.

    None are told of where they come to a vertex twice, which only rounding, or a polytope that is
    not convex, can make: a cone over them would not be linked in one way.
    """
    one = signed(1)
    for s in range(unsigned(count)):
        f = unsigned(seen[s])
        for k in range(3):
            masks[unsigned(corners[at(k, f)])] = 0
    for s in range(unsigned(count)):
        f = unsigned(seen[s])
        for k in range(3):
            masks[unsigned(corners[at(k, f)])] |= one << signed(corners[at((k + 1) % 3, f)])
    edges, starts, twice = 0, signed(0), signed(0)
    for s in range(unsigned(count)):
        f = unsigned(seen[s])
        for k in range(3):
            start, end = signed(corners[at(k, f)]), signed(corners[at((k + 1) % 3, f)])
            here = unsigned(2 * edges)
            horizon[here], horizon[here + unsigned(1)] = start, end
            outer = one - ((masks[unsigned(end)] >> start) & one)
            twice |= outer & (starts >> start)
            starts |= outer << start
            edges += outer
    return 0 if twice != 0 else edges


@inlined
def expand(
    growth: tuple[Floats, Integers32, Floats, Indices, Integers32, Integers32],
    count: int,
    total: int,
    thickness: float,
) -> tuple[int, int]:
    """Put a cone with the apex ``count`` in place of the faces that see it.

    Return the new number of faces, whose last ones are those of the cone, and how many these are:
    0 where nothing was changed.
    """
    points, corners, planes, masks, seen, horizon = growth
    killed = faces_that_see(planes, total, vector_in(points, count), thickness, seen)
    edges = horizon_of(corners, seen, killed, masks, horizon)
    if edges == 0 or total - killed + edges > MOST_ROWS - LANES:
        return total, 0
    for s in range(killed):
        here, last = unsigned(seen[unsigned(killed - 1 - s)]), unsigned(total - 1 - s)
        for k in range(3):
            corners[at(k, here)] = corners[at(k, last)]
        for k in range(PLANE_ROWS):
            planes[at(k, here)] = planes[at(k, last)]
    first = total - killed
    for e in range(unsigned(edges)):
        start, end = horizon[e + e], horizon[e + e + unsigned(1)]
        set_corners(corners, unsigned(first) + e, start, end, count)
    return first + edges, edges


@compiled
def is_closed(corners: Integers32, count: int, total: int, masks: Indices) -> bool:
    """Tell whether faces of ``count`` vertices are closed surfaces.

    Then each edge is there once in each direction.
    """
    one, spoilt = signed(1), signed(0)
    for v in range(unsigned(2 * count)):
        masks[v] = 0
    for f in range(unsigned(total)):
        for k in range(3):
            start, end = signed(corners[at(k, f)]), signed(corners[at((k + 1) % 3, f)])
            there, back = unsigned(start), unsigned(count + end)
            spoilt |= ((masks[there] >> end) & one) | signed(start == end)
            masks[there] |= one << end
            masks[back] |= one << start
    for v in range(unsigned(count)):
        spoilt |= masks[v] ^ masks[v + unsigned(count)]
    return spoilt == 0
