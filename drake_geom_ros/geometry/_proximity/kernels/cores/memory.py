"""Memory of two hulls for a warm start: the polytope of an earlier answer, in a result row.

``memory`` has the numbers of vertices and of faces, the position of B from A, MOST_VERTICES names,
and MOST_FACES faces, two per number. A name is the index of A's vertex (see ``hulls``) plus NAMES
times that of B's. A face is its three vertices, in eight bits each. The memory is empty if its
first number is 0. All of it is validated before use.
"""

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import put
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.cores.small_polytope import (
    MOST_GROWN,
    NAME,
    at,
    is_closed,
    set_corners,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.vectors import add, dot, rotate, sub, vector_at
from drake_geom_ros.geometry._proximity.kinds import VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.arrays import (
    Floats,
    Indices,
    Integers32,
    Vector,
    signed,
    unsigned,
)
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined

MOST_VERTICES = 22
MOST_FACES = 2 * MOST_VERTICES - 4
POSITION = 2  # 3: of B from A [m]
FIRST_NAME = 5
FIRST_FACE = FIRST_NAME + MOST_VERTICES
FAR = 0.125  # of the size: after a larger motion the memory is not used
NAMES = 2**24
MOST_BITS = 2**48  # upper bound of names and pairs of faces


@inlined
def is_where_it_was(memory: Floats, p: Vector, size: float) -> bool:
    """Return whether B is near its remembered position relative to A."""
    moved = sub(p, vector_at(memory, POSITION))
    return dot(moved, moved) <= (FAR * size) * (FAR * size)


@inlined
def remember_position(memory: Floats, p: Vector) -> None:
    """Store the position of B from A."""
    for k in range(3):
        memory[POSITION + k] = p[k]


@compiled
def recall_faces(memory: Floats, corners: Integers32, count: int, total: int) -> bool:
    """Fill in the faces from memory; return whether their numbers are valid."""
    for k in range((total + 1) // 2):
        number = memory[FIRST_FACE + k]
        if not 0.0 <= number < MOST_BITS:
            return False
        bits = signed(number)
        f = 2 * k
        set_corners(corners, f, bits & 255, (bits >> 8) & 255, (bits >> 16) & 255)
        f += 1  # may be beyond the last one, which does no harm
        set_corners(corners, f, (bits >> 24) & 255, (bits >> 32) & 255, bits >> 40)
    highest = 0
    for k in range(3):
        for f in range(unsigned(total)):
            highest = max(highest, corners[at(k, f)])
    return highest < count


@compiled
def recall(
    memory: Floats, pair: CorePair, points: Floats, corners: Integers32, masks: Indices
) -> tuple[int, int]:
    """Fill in the posed vertices and the faces; return (count, total), (0, 0) if invalid."""
    _, shape_A, R_WA, _, shape_B, R_WB, p = pair
    if not (4.0 <= memory[0] <= MOST_VERTICES and 4.0 <= memory[1] <= MOST_FACES):
        return 0, 0
    count, total = int(memory[0]), int(memory[1])
    if not recall_faces(memory, corners, count, total):
        return 0, 0
    if not is_closed(corners, count, total, masks):
        return 0, 0
    for k in range(count):
        name = memory[FIRST_NAME + k]
        if not 0.0 <= name < MOST_BITS:
            return 0, 0
        i, j = int(name) % NAMES, int(name) // NAMES
        if not (1 <= i <= shape_A[VERTEX_COUNT] and 1 <= j <= shape_B[VERTEX_COUNT]):
            return 0, 0
        a, b = (rotate(R_WA, vertex_at(shape_A, i)), add(p, rotate(R_WB, vertex_at(shape_B, j))))
        put(points, k, a, b)
        points[k, NAME] = float(i + NAMES * j)
    return count, total


@compiled
def keep(
    memory: Floats, points: Floats, corners: Integers32, total: int, numbers: Indices
) -> None:
    """Store the faces and their vertices, or nothing if there are too many.

    ``numbers`` is scratch for the numbers of the vertices.
    """
    memory[0] = 0.0
    if total > MOST_FACES:
        return
    count = 0
    for v in range(MOST_GROWN):
        numbers[v] = -1
    for f in range(unsigned(total)):
        bits = signed(0)
        for k in range(3):
            v = unsigned(corners[at(k, f)])
            if numbers[v] < 0:
                if count == MOST_VERTICES:
                    return
                numbers[v] = count
                memory[FIRST_NAME + count] = points[v, NAME]
                count += 1
            bits |= numbers[v] << (8 * k)
        here = FIRST_FACE + signed(f) // 2
        memory[here] = float(bits) if signed(f) % 2 == 0 else memory[here] + 2.0**24 * bits
    memory[0], memory[1] = float(count), float(total)
