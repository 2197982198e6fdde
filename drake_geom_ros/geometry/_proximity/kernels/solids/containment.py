"""The relation of two bodies: they overlap, touch, are apart, or may overlap.

Triangles decide it for two solids (``meetings``, ``rays``), without error where the pose swaps
axes at most, and for a box and a solid. Where corners are turned, bodies that touch may overlap by
less than rounding, and a body that fits between walls so closely has no way out but the one
through the opening: then only what holds for all corners within rounding is certain. Bodies are
given as in ``distance``.
"""

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import OVERLAP
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import vertex_at
from drake_geom_ros.geometry._proximity.kernels.solids.distance import NEVER, Nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import middle_of
from drake_geom_ros.geometry._proximity.kernels.solids.meetings import TOUCH
from drake_geom_ros.geometry._proximity.kernels.solids.rays import (
    Posed,
    is_beneath_within,
    swaps_axes,
    triangle_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    CORNERS,
    SolidPair,
    Tree,
    TreeBody,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.touching import meet_anywhere
from drake_geom_ros.geometry._proximity.kernels.solids.winding import is_inside
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import LOWER, NO_BOX, NODE_WIDTH, UPPER
from drake_geom_ros.geometry._proximity.kernels.vectors import norm
from drake_geom_ros.geometry._proximity.kinds import BOX, CONVEX, SOLID, SPHERE, VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled
from drake_geom_ros.geometry._proximity.tolerances import EPS

# Relations of two bodies.
APART = 0  # by more than rounding
TOUCHES = 1  # decided without error
MAY_OVERLAP = 2  # they touch, or overlap by less than rounding
OVERLAPS = 3

FLUSH = 16.0  # roundings that leaves which touch may be apart
TURNED = 8.0 * EPS  # of a corner that is turned and moved, over how far it is from either origin

# The faces of a box, two triangles each, counter-clockwise from outside: corner k is at the upper
# end of x, y, z where k has the bits 4, 2, 1.
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
BOX_TREE = Tree(0, 1, NODE_WIDTH, 12, NODE_WIDTH + 12 * CORNERS, 1, 0, 0, 0, 0)


@compiled
def bounds_if_box(A: TreeBody) -> tuple[bool, Vector, Vector]:
    """Return (is_box, low, high): whether a core is a box along its axes, and its corners."""
    if A.kind == BOX:
        x, y, z = A.shape[0], A.shape[1], A.shape[2]
        return True, (-x, -y, -z), (x, y, z)
    nothing = (0.0, 0.0, 0.0)
    if A.kind != CONVEX or A.shape[VERTEX_COUNT] != 8.0:
        return False, nothing, nothing
    low = high = vertex_at(A.shape, 1)
    for k in range(2, 9):
        v = vertex_at(A.shape, k)
        low = min(low[0], v[0]), min(low[1], v[1]), min(low[2], v[2])
        high = max(high[0], v[0]), max(high[1], v[1]), max(high[2], v[2])
    for k in range(1, 9):
        v = vertex_at(A.shape, k)
        for c in range(3):
            if v[c] != low[c] and v[c] != high[c]:
                return False, nothing, nothing
    return True, low, high


@allocating
def box_as_solid(A: TreeBody, low: Vector, high: Vector) -> TreeBody:
    """Return a box as the solid of its twelve triangles."""
    shape = np.zeros(NODE_WIDTH + 12 * CORNERS + 1)
    for c in range(3):
        shape[LOWER + c], shape[UPPER + c] = low[c], high[c]
    for f in range(6):
        for t in range(2):
            for k in range(3):
                corner = QUADS[f][0] if k == 0 else QUADS[f][t + k]
                at = NODE_WIDTH + CORNERS * (2 * f + t) + 3 * k
                for c in range(3):
                    shape[at + c] = high[c] if corner & (4 >> c) else low[c]
    return TreeBody(SOLID, shape, A.R, BOX_TREE, NO_BOX)


@compiled
def touch_of(pair: SolidPair) -> float:
    """Return the separation [m] below which triangles decide, NEVER of bodies without such."""
    if pair.A.kind == SOLID or bounds_if_box(pair.A)[0]:
        return noise_of(pair)
    return NEVER


@compiled
def is_piece_within(posed: Posed, other: Posed) -> bool:
    """Return whether what is just beneath a triangle of any piece of a solid is in the other."""
    tree = posed.tree
    for k in range(tree.pieces):
        j = int(posed.shape[tree.pieces_at + k])
        if is_beneath_within(triangle_of(posed, j), other):
            return True
    return False


@compiled
def is_touched_within(posed: Posed, other: Posed, touch_bits: Indices) -> bool:
    """Return whether what is beneath a triangle that is only known to touch is in the other."""
    for j in range(touch_bits.size):
        if touch_bits[j] == TOUCH and is_beneath_within(triangle_of(posed, j), other):
            return True
    return False


@compiled
def rounding_of_places(A: TreeBody, p: Vector) -> float:
    """Return how far off [m] the corners of a solid A may be in B; 0 where nothing is rounded."""
    if swaps_axes(A.R):
        return 0.0
    root, far = A.tree.nodes, norm(p)
    for c in range(3):
        far += max(abs(A.shape[root + LOWER + c]), abs(A.shape[root + UPPER + c]))
    return TURNED * far


@allocating
def stand_of_solids(pair: SolidPair, touches: bool, ways: Floats) -> tuple[int, int]:
    """Return the relation of two solids, and the number of ``ways`` apart found where they touch.

    If they have an inside in common, a face of what they have in common lies on a triangle of one,
    and just beneath it is the inside of the other. Triangles that touch the other's surface are
    examined, and one of each piece for all of its triangles that do not.
    """
    A, B, p = pair.A, pair.B, pair.p
    off = rounding_of_places(A, p)
    posed_A = Posed(A.shape, A.tree, A.R, p, off)
    posed_B = Posed(B.shape, B.tree, B.identity, (0.0, 0.0, 0.0), off)
    open_, count = False, 0
    if touches:
        bits_A = np.zeros(A.tree.triangles, dtype=np.int64)
        bits_B = np.zeros(B.tree.triangles, dtype=np.int64)
        reach = FLUSH * noise_of(pair)
        met = meet_anywhere(pair, (posed_A, posed_B), reach, (bits_A, bits_B), ways)
        if met.overlapping:
            return OVERLAPS, 0
        if is_touched_within(posed_A, posed_B, bits_A) or is_touched_within(
            posed_B, posed_A, bits_B
        ):
            return OVERLAPS, 0
        open_, count = met.touches and off > 0.0, met.ways
    if is_piece_within(posed_A, posed_B) or is_piece_within(posed_B, posed_A):
        return OVERLAPS, 0
    if open_:
        return MAY_OVERLAP, count
    return TOUCHES if touches else APART, count


@allocating
def stand_of(pair: SolidPair, closest: Nearest, ways: Floats) -> tuple[int, int]:
    """Return the relation of A and B, by ``closest``, and the number of ``ways`` (k, WAY_WIDTH).

    Triangles decide where solids or boxes touch to rounding. Else a core with a volume crosses any
    triangle within it, which ``nearest`` reports; it remains that the core is in B, and then its
    middle is. A core without a volume is a point or a segment with a ball around it, which
    overlaps where the core touches, unless the ball is as small as rounding.
    """
    A, B, noise = pair.A, pair.B, noise_of(pair)
    if closest.end == OVERLAP or closest.upper - pair.radius < -noise:
        return OVERLAPS, 0
    touches = closest.lower - pair.radius <= noise
    if A.kind == SOLID:
        return stand_of_solids(pair, touches, ways)
    if touches:
        is_box, low, high = bounds_if_box(A)
        if is_box:
            body = box_as_solid(A, low, high)
            as_solids = SolidPair(body, B, pair.p, pair.size, pair.tolerance, pair.radius)
            return stand_of_solids(as_solids, True, ways)
    on_surface = touches and A.kind == SPHERE
    if not on_surface and is_inside(B.shape, B.tree, middle_of(A, pair.p)):
        return OVERLAPS, 0
    return MAY_OVERLAP if touches else APART, 0
