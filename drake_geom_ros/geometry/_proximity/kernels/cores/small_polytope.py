"""Polytope of few vertices, without links: each step examines all its triangles by SIMD.

Two hulls take 10 to 25 vertices. Links, a heap and dead faces (``polytope``) then cost more than
they save: a depth of two hulls takes 1.4 times as long. Here vectorised loops over all faces find
the nearest one and those that see a vertex; these are removed, and the last faces fill their
places. An edge of a removed face is on the horizon if no removed face has it in the opposite
direction. To test that, the ends of the edges from a vertex are the bits of a number, so no
polytope has more vertices than MOST_GROWN.

``corners`` has three rows of vertices by face, counter-clockwise seen from outside. ``planes`` has
rows for the unit normals out of the polytope, for the least offset of the vertices along them, and
for the *key*: the offset, or infinity where a face need not be examined; further rows are scratch.
Rows are parts of flat arrays, MOST_ROWS long (``at``): LLVM then knows that they do not overlap,
and vectorises over faces. Vertices are rows as written by ``gjk.put``, with a name at the end.
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

# Most vertices of a polytope; usual are 10 to 25. There are 2 n - 4 faces, except for recalled
# surfaces, which may be several.
MOST_GROWN = 40
MOST_ROWS = 96  # LANES of them are padding
POINT_WIDTH = 10
NAME = 9  # column of the points
OFFSET, KEY = 3, 4  # rows of the planes, after the normal
PLANE_ROWS = 5
ABOVE = 5  # scratch row: height of a vertex above a face
PLACES = 6  # scratch rows, 9: x, y and z of the corners
MOST_EDGES = 3 * MOST_ROWS + 1


@inlined
def growth_numbers() -> int:
    """Return the size of the block for growing a polytope."""
    return (POINT_WIDTH + 2) * MOST_GROWN + (PLACES + 9) * MOST_ROWS + 2 * MOST_ROWS + MOST_EDGES


@allocating
def growth_arrays(
    block: Floats,
) -> tuple[Floats, Integers32, Floats, Indices, Integers32, Integers32]:
    """Return the arrays of a growing polytope: (points, corners, planes, masks, seen, horizon).

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
    """Return the index of face f in a row of corners or planes."""
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
    """Set the vertices i, j and k of face f."""
    corners[at(0, f)], corners[at(1, f)], corners[at(2, f)] = i, j, k


@inlined
def place_of(planes: Floats, row: int, f: int) -> Vector:
    """Return three scratch numbers of a face, from a row on."""
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
    """Set the planes and keys of the faces from ``first`` to ``total``.

    As in ``polytope.set_planes``, a loop without branches is followed by ``plane_of`` for faces
    that would lose digits. Corners are copied side by side, and the number of faces is rounded up
    to a multiple of LANES, so that LLVM vectorises the loop; rows beyond the last face are unused.
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
        highest = max(x, y, z)
        offset = -max(-x, -y, -z)
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
    """Set the planes of slivers, which ``set_planes`` left out."""
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
    """Return the first face with the least key; the number of faces if there is none."""
    end, least = unsigned(total), -np.inf  # of negated keys, so that ``max`` applies
    for f in range(unsigned(0), end):
        least = max(-planes[at(KEY, f)], least)
    best = end
    for f in range(unsigned(0), end):
        best = min(best, f if -planes[at(KEY, f)] == least else end)
    return signed(best)


@inlined
def faces_that_see(
    planes: Floats, total: int, w: Vector, thickness: float, seen: Integers32
) -> int:
    """List the faces that w is above by more than ``thickness`` [m]; return how many.

    Without the thickness, rounding would decide about faces coplanar with w.
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
    """Write the horizon, the edges around ``count`` listed faces; return their number, or 0.

    It is 0 if the horizon passes a vertex twice, which rounding or a polytope that is not convex
    can cause: a cone over it would be ambiguous.
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
    """Replace the faces that see the vertex ``count`` by a cone with that apex.

    Return the new number of faces, of which the last are the cone, and the number of faces of the
    cone: 0 if nothing was changed.
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
    """Return whether faces of ``count`` vertices form closed surfaces.

    Then each edge occurs once in each direction.
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
