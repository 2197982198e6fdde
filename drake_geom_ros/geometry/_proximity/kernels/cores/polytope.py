"""Growing polytope of EPA: linked triangles of a closed surface, and a heap of their offsets.

A face is a row of integers (three vertices, the faces across its edges 01, 12 and 20, and a flag
whether it is alive) and a row of numbers (its plane: a unit normal out of the polytope and the
least offset of its vertices along it). Dead faces retain their row. Vertices are rows as written
by ``gjk.put``.

Row indices are unsigned, because the test for negative ones costs a tenth of EPA.
"""

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put
from drake_geom_ros.geometry._proximity.kernels.cores.simplices import (
    closest_on_triangle,
    weighted,
)
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    cross,
    dot,
    perpendicular,
    scale,
    sub,
    unit,
    vector_in,
)
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Integers32, Vector, unsigned
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import integers, part, table
from drake_geom_ros.geometry._proximity.tolerances import (
    COPLANAR,
    EPS,
    LARGE_SQUARE,
    SLIVER,
    SMALL_SQUARE,
)

ACROSS = 3
ALIVE = 6
FACE_WIDTH = 7
OFFSET = 3
PLANE_WIDTH = 4
START, END, BEYOND = 0, 1, 2  # columns of a horizon
ZERO = (0.0, 0.0, 0.0)


@inlined
def growth_numbers(most_vertices: int) -> int:
    """Return the size of the block for growing a polytope to ``most_vertices``."""
    rows = 8 * most_vertices
    return 10 * most_vertices + PLANE_WIDTH * rows + ((FACE_WIDTH + 5) * rows + most_vertices) // 2


@allocating
def growth_arrays(
    block: Floats, most_vertices: int
) -> tuple[Floats, Integers32, Floats, Integers32, Integers32, Integers32, Integers32]:
    """Return the arrays for growing a polytope to ``most_vertices``, as views of a block.

    They are passed on individually, because as a record they made EPA 12 % slower. All are in one
    block of ``growth_numbers``, because allocating and freeing a second one takes as long as 4
    more vertices. They are views, because slices and reshaped arrays took a tenth of the time of
    two hulls.
    """
    rows, corners = 8 * most_vertices, 10 * most_vertices  # columns: w, a, b, and a name
    rest = integers(block, corners + PLANE_WIDTH * rows)
    faces, horizon = FACE_WIDTH * rows, (FACE_WIDTH + 3) * rows
    starting_at = part(rest, horizon + 2 * rows, horizon + 2 * rows + most_vertices)
    starting_at[:] = -1
    return (
        table(block, 0, most_vertices, 10),
        table(rest, 0, rows, FACE_WIDTH),
        table(block, corners, rows, PLANE_WIDTH),
        table(rest, faces, rows, 3),
        part(rest, horizon, horizon + rows),
        starting_at,
        part(rest, horizon + rows, horizon + 2 * rows),
    )


@inlined
def normal(a: Vector, b: Vector, c: Vector) -> Vector:
    """Return the unit normal of a triangle from its two shorter edges; 0 for collinear corners.

    The angle between the two longer edges of a thin triangle is mostly rounding.
    """
    ab, bc, ca = sub(b, a), sub(c, b), sub(a, c)
    x, y, z = dot(ab, ab), dot(bc, bc), dot(ca, ca)
    if y >= x and y >= z:
        return unit(cross(ca, ab))
    if z >= x:
        return unit(cross(ab, bc))
    return unit(cross(bc, ca))


@compiled
def plane_of(a: Vector, b: Vector, c: Vector, size: float) -> tuple[Vector, float]:
    """Return (n, offset) of a triangle: from its corners, or for a sliver from its nearest point.

    ``n`` is a unit normal, ``offset`` [m] the least one of the corners along it.
    """
    n = normal(a, b, c)
    x, y, z = dot(n, a), dot(n, b), dot(n, c)
    offset = min(x, y, z)
    if n == ZERO or max(x, y, z) - offset > SLIVER * size:
        nearest = weighted(a, b, c, closest_on_triangle(a, b, c))
        # For a face with the origin in front of it, the nearest point is along -n.
        m = scale(1.0 if dot(nearest, n) >= 0.0 else -1.0, unit(nearest))
        if m == ZERO and n == ZERO:
            m = perpendicular(unit(sub(b, a) if b != a else sub(c, a)))
        if m == ZERO and n == ZERO:
            m = (1.0, 0.0, 0.0)
        away = min(dot(m, a), dot(m, b), dot(m, c))
        if n == ZERO or (m != ZERO and away > offset):
            n, offset = m, away
    return n, offset


@compiled
def set_plane(faces: Integers32, planes: Floats, points: Floats, f: int, size: float) -> None:
    """Set the plane of face f."""
    f = unsigned(f)
    n, offset = plane_of(
        vector_in(points, faces[f, 0]),
        vector_in(points, faces[f, 1]),
        vector_in(points, faces[f, 2]),
        size,
    )
    for k in range(3):
        planes[f, k] = n[k]
    planes[f, OFFSET] = offset


@inlined
def is_corner(points: Floats, faces: Integers32, f: int, w: Vector) -> bool:
    """Return whether w is a vertex of face f, so that expanding the face gains nothing."""
    i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
    return vector_in(points, i) == w or vector_in(points, j) == w or vector_in(points, k) == w


@compiled
def link_tetrahedron(points: Floats, faces: Integers32) -> None:
    """Make faces 0 to 3 of vertices 0 to 3, linked, counter-clockwise seen from outside."""
    a, b, c, d = (
        vector_in(points, 0),
        vector_in(points, 1),
        vector_in(points, 2),
        vector_in(points, 3),
    )
    i, j = (1, 2) if dot(sub(d, a), cross(sub(b, a), sub(c, a))) <= 0.0 else (2, 1)
    corners = ((0, i, j), (0, 3, i), (0, j, 3), (i, 3, j))
    across = ((1, 3, 2), (2, 3, 0), (0, 3, 1), (1, 2, 0))
    for f in range(4):
        for k in range(3):
            faces[f, k] = corners[f][k]
            faces[f, ACROSS + k] = across[f][k]
        faces[f, ALIVE] = 1


@inlined
def cut_visible(
    faces: Integers32,
    planes: Floats,
    f: int,
    w: Vector,
    thickness: float,
    stack: Integers32,
    horizon: Integers32,
) -> int:
    """Kill the faces that see w, from f outwards, and write their horizon; return its length.

    A row of the horizon is an edge of a killed face and the living face across it. A face sees w
    if w is above its plane by more than ``thickness``. Otherwise rounding would decide about faces
    coplanar with w, and a cone over such a horizon may fold back on itself.
    """
    faces[f, ALIVE] = 0
    stack[0] = f
    waiting, edges = 1, 0
    while waiting > 0:
        waiting -= 1
        g = unsigned(stack[waiting])
        for k in range(3):
            other = unsigned(faces[g, ACROSS + k])
            if faces[other, ALIVE] == 0:
                continue
            if dot(vector_in(planes, other), w) > planes[other, OFFSET] + thickness:
                faces[other, ALIVE] = 0
                stack[waiting] = other
                waiting += 1
            else:
                horizon[edges, START] = faces[g, k]
                horizon[edges, END] = faces[g, (k + 1) % 3]
                horizon[edges, BEYOND] = other
                edges += 1
    return edges


@inlined
def link_cone(
    faces: Integers32,
    horizon: Integers32,
    edges: int,
    apex: int,
    total: int,
    starting_at: Integers32,
) -> int:
    """Link a new face from each horizon edge to the vertex ``apex``; return the number of faces.

    ``starting_at`` is scratch, by vertex: the new face that begins at it, -1 for none. A horizon
    that passes a vertex twice, which only rounding can cause, is not linked. Then the old number
    of faces is returned, and the surface is no longer closed.
    """
    for i in range(edges):
        start, end = horizon[i, START], horizon[i, END]
        other = unsigned(horizon[i, BEYOND])
        if starting_at[start] >= total:
            return total
        f = unsigned(total + i)
        faces[f, 0], faces[f, 1], faces[f, 2] = start, end, apex
        faces[f, ACROSS], faces[f, ALIVE] = other, 1
        for k in range(3):
            if faces[other, k] == end and faces[other, (k + 1) % 3] == start:
                faces[other, ACROSS + k] = f
        starting_at[start] = f
    for i in range(edges):
        f = unsigned(total + i)
        after = unsigned(starting_at[unsigned(faces[f, 1])])
        faces[f, ACROSS + 1] = after
        faces[after, ACROSS + 2] = f
    return total + edges


@inlined
def push(heap: Integers32, count: int, planes: Floats, f: int) -> None:
    """Push face f onto the heap of offsets."""
    k, one = unsigned(count), unsigned(1)
    offset = planes[unsigned(f), OFFSET]
    while k > 0:
        parent = (k - one) >> one
        if planes[unsigned(heap[parent]), OFFSET] <= offset:
            break
        heap[k] = heap[parent]
        k = parent
    heap[k] = f


@compiled
def pop_living(
    faces: Integers32, planes: Floats, heap: Integers32, waiting: int
) -> tuple[int, int]:
    """Pop the living face of least offset; return it, or -1, and the new size of the heap."""
    least, one = -1, unsigned(1)
    while waiting > 0 and least < 0:
        if faces[unsigned(heap[0]), ALIVE] == 1:
            least = heap[0]
        waiting -= 1
        end = unsigned(waiting)
        last = heap[end]
        offset = planes[unsigned(last), OFFSET]
        k, child = unsigned(0), one
        while child < end:
            right = child + one
            ahead = planes[unsigned(heap[child]), OFFSET]
            if right < end and planes[unsigned(heap[right]), OFFSET] < ahead:
                child, ahead = right, planes[unsigned(heap[right]), OFFSET]
            if offset <= ahead:
                break
            heap[k] = heap[child]
            k, child = child, child + child + one
        heap[k] = last
    return least, waiting


@compiled
def set_planes(
    points: Floats, faces: Integers32, planes: Floats, first: int, total: int, size: float
) -> float:
    """Set the planes of the faces from ``first`` to ``total``; return their least offset [m].

    One loop without branches takes a quarter of the time of as many calls of ``set_plane``. That
    function handles the faces that would lose digits: thin ones, and those so tiny or huge that
    their squares may vanish or overflow.
    """
    least, unset = np.inf, False
    for f in range(unsigned(first), unsigned(total)):
        a, b, c = (
            vector_in(points, faces[f, 0]),
            vector_in(points, faces[f, 1]),
            vector_in(points, faces[f, 2]),
        )
        n = cross(sub(b, a), sub(c, b))
        squared = dot(n, n)
        area = math.sqrt(squared)
        n = scale(1.0 / area if area > 0.0 else 0.0, n)
        x, y, z = dot(n, a), dot(n, b), dot(n, c)
        offset = min(x, y, z)
        level = max(x, y, z) - offset <= COPLANAR * EPS * size
        usual = (squared > SMALL_SQUARE) & (squared < LARGE_SQUARE) & level
        offset = offset if usual else np.inf
        planes[f, 0], planes[f, 1], planes[f, 2], planes[f, OFFSET] = (n[0], n[1], n[2], offset)
        least, unset = min(least, offset), unset | (not usual)
    if unset:
        for f in range(unsigned(first), unsigned(total)):
            if planes[f, OFFSET] == np.inf:
                set_plane(faces, planes, points, f, size)
                least = min(least, planes[f, OFFSET])
    return least


@compiled
def add_faces(
    points: Floats,
    faces: Integers32,
    planes: Floats,
    heap: Integers32,
    first: int,
    total: int,
    waiting: int,
    size: float,
) -> int:
    """Set the planes of the faces from ``first`` to ``total``, and push them onto the heap."""
    set_planes(points, faces, planes, first, total, size)
    return push_nearest(heap, planes, first, total, waiting, np.inf)


@inlined
def push_nearest(
    heap: Integers32, planes: Floats, first: int, total: int, waiting: int, rival: float
) -> int:
    """Push the faces from ``first`` on with offsets up to ``rival`` [m] onto the heap."""
    for f in range(unsigned(first), unsigned(total)):
        if planes[f, OFFSET] <= rival:
            push(heap, waiting, planes, f)
            waiting += 1
    return waiting


@compiled
def expand(
    points: Floats,
    faces: Integers32,
    planes: Floats,
    horizon: Integers32,
    stack: Integers32,
    starting_at: Integers32,
    f: int,
    a: Vector,
    b: Vector,
    count: int,
    total: int,
    size: float,
) -> int:
    """Add the vertex a - b, number ``count``, and replace the faces that see it, including f.

    Return the new number of faces. It is unchanged if the surface could not be closed again,
    because the arrays are full or rounding spoilt the horizon.
    """
    put(points, count, a, b)
    w = vector_in(points, count)
    edges = cut_visible(faces, planes, f, w, COPLANAR * EPS * size, stack, horizon)
    if total + edges > faces.shape[0]:
        return total
    return link_cone(faces, horizon, edges, count, total, starting_at)
