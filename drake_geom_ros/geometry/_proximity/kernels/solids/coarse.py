"""Distance of two solids to an accuracy that is wanted: points above, coins below.

Two points of the surfaces bound the distance from above, and they are found first: each is the
nearest on its surface to the other (alternating projections, von Neumann), to less than the
accuracy. The coins of two trees' nodes bound it from below: a walk leaves out what is farther than
the best two points less the accuracy, and looks at triangles only where coins do not decide. Where
a millimetre is wanted, this is most of a mesh of 20 000 triangles, and all of it where a
centimetre is.

The accuracy is rounded down to a power of 2, a *class*, and to half of the distance of the first
two points, so that small gaps are seen. Bounds are widened to half the class where they are
narrower: so no larger accuracy has narrower ones by luck. Bodies are given as in ``distance``.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import BEYOND_CUTOFF, CLOSED, OVERLAP
from drake_geom_ros.geometry._proximity.kernels.solids.coins import (
    Coin,
    coin_of_node,
    coins_at,
    is_thick,
    posed_coin,
    separation_beside,
    separation_of_coins,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import Nearest
from drake_geom_ros.geometry._proximity.kernels.solids.lane_tree import lane_tree_of
from drake_geom_ros.geometry._proximity.kernels.solids.leaves import (
    gap_of_leaves,
    leaf_of_A,
    leaf_of_B,
    separation_of_leaves,
)
from drake_geom_ros.geometry._proximity.kernels.solids.nearest_triangles import (
    FEW,
    FULL,
    PointScratch,
    nearest_triangles,
    rounding_at,
    scratch_for,
)
from drake_geom_ros.geometry._proximity.kernels.solids.solid import (
    AREA,
    SolidPair,
    Tree,
    first_of_leaf,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.solids.to_points import (
    OUTSIDE,
    first_of,
    side_of_surface,
)
from drake_geom_ros.geometry._proximity.kernels.trees.boxes import (
    box_of_node,
    separation_of_turned_boxes,
)
from drake_geom_ros.geometry._proximity.kernels.trees.walks import DEEPEST, Walk, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    norm,
    rotate,
    sub,
    unit,
    unrotate,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.tolerances import COARSE, ROUNDINGS_OF_A_CLASS

MOST_PROJECTIONS = 4  # onto either surface; most pairs take two or three
GAIN = 2.0**-6  # of a distance [-] by which another projection has to shorten it
OF_A_LEAF = 0.1  # of the size of a leaf [-] that a class has to be; measured on balls and boxes
SHARE = 0.5  # of the distance of the first points [-] that the class may be


class Coarse(NamedTuple):
    """The nearest points to a class [m] of accuracy, 0 where the kernel of ``exact`` answers.

    If ``is_apart``, the bodies are certified to be, and ``closest`` holds; the rest of a class
    that is not is meaningless.
    """

    length: float
    is_apart: bool
    closest: Nearest


@inlined
def class_of(length: float) -> float:
    """Return the largest power of 2 that is no larger than a length [m]."""
    _, exponent = math.frexp(length)
    return math.ldexp(1.0, exponent - 1)


@allocating
def project(
    shape: Floats, tree: Tree, q: Vector, scratch: PointScratch
) -> tuple[Vector, int, PointScratch]:
    """Return (b, count, scratch): the point of a surface nearest to q, in the solid's frame.

    The triangles that are as near are the first ``count`` of the scratch.
    """
    extent = 2.0 * norm(box_of_node(shape, tree, 0).half)
    lanes = lane_tree_of(tree)
    count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
    while count == FULL:
        scratch = scratch_for(lanes, 2 * scratch.triangles.size)
        count = nearest_triangles(shape, tree, lanes, q, extent, scratch)
    return add(q, vector_in(scratch.vectors, first_of(count, scratch))), count, scratch


@compiled
def is_outside(shape: Floats, tree: Tree, q: Vector, count: int, scratch: PointScratch) -> bool:
    """Return whether q is certified to be outside, by the triangles that ``project`` found."""
    distance = scratch.away[first_of(count, scratch)]
    noise = rounding_at(distance, 2.0 * norm(box_of_node(shape, tree, 0).half))
    return side_of_surface(shape, tree, q, distance, noise, count, scratch) == OUTSIDE


@allocating
def projected(pair: SolidPair) -> tuple[bool, Vector, Vector]:
    """Return (are_outside, a, b): points of both surfaces, each nearest to the other, or nearly.

    ``are_outside`` is whether a point of each is certified to be outside the other body.
    """
    A, B, p, R = pair.A, pair.B, pair.p, pair.A.R
    on_A, on_B = (
        scratch_for(lane_tree_of(A.tree), FEW),
        scratch_for(lane_tree_of(B.tree), FEW),
    )
    b, of_B, on_B = project(
        B.shape, B.tree, add(rotate(R, box_of_node(A.shape, A.tree, 0).middle), p), on_B
    )
    a, of_A, before = b, 0, math.inf
    for _ in range(MOST_PROJECTIONS):
        q = unrotate(R, sub(b, p))
        x, of_A, on_A = project(A.shape, A.tree, q, on_A)
        a = add(rotate(R, x), p)
        b, of_B, on_B = project(B.shape, B.tree, a, on_B)
        d = norm(sub(b, a))
        if d > (1.0 - GAIN) * before:
            break
        before = d
    are_outside = is_outside(A.shape, A.tree, q, of_A, on_A)
    return are_outside and is_outside(B.shape, B.tree, a, of_B, on_B), a, b


@inlined
def _push_children(
    pair: SolidPair,
    coins: tuple[int, int],
    nodes: tuple[int, int],
    both: tuple[Coin, Coin],
    path: Walk,
    top: int,
) -> int:
    """Split a pair of nodes, not both leaves, and push the two pairs, the nearer one last.

    ``both`` are the coins of the nodes; ``coins`` say where those of A and of B begin.
    """
    A, B, p = pair.A, pair.B, pair.p
    (i, j), (in_A, in_B) = nodes, both
    if is_leaf(A.tree, i) or (not is_leaf(B.tree, j) and in_B.radius >= in_A.radius):
        i_step, j_step, i, j = 0, 1, i, 2 * j + 1
        first = separation_of_coins(in_A, coin_of_node(B.shape, coins[1], j))
        second = separation_of_coins(in_A, coin_of_node(B.shape, coins[1], j + 1))
    else:
        i_step, j_step, i, j = 1, 0, 2 * i + 1, j
        first = separation_of_coins(posed_coin(A, coins[0], p, i), in_B)
        second = separation_of_coins(posed_coin(A, coins[0], p, i + 1), in_B)
    k = top if second < first else top + 1  # the nearer pair is pushed last
    path.stack[k, 0], path.stack[k, 1], path.separations[k] = i, j, first
    k = 2 * top + 1 - k
    path.stack[k, 0], path.stack[k, 1], path.separations[k] = i + i_step, j + j_step, second
    return top + 2


@compiled
def _nearer_in_leaves(
    pair: SolidPair, i: int, j: int, best: float, slack: float
) -> tuple[int, float, float, Vector, Vector]:
    """Return (end, best, least, a, b) of the triangles of two leaves, as ``nearest`` has them.

    Triangles farther than ``best`` less ``slack`` [m] are left out. End OVERLAP: two cross.
    """
    A, B = pair.A, pair.B
    least, a, b, n = math.inf, pair.p, pair.p, (1.0, 0.0, 0.0)
    for k in range(first_of_leaf(A.tree, i), first_of_leaf(A.tree, i + 1)):
        leaf_A = leaf_of_A(pair, k)
        for m in range(first_of_leaf(B.tree, j), first_of_leaf(B.tree, j + 1)):
            gap = gap_of_leaves(leaf_A, leaf_of_B(B, m), False)
            if gap <= best - slack:
                end, upper, gap, _, x, y, _ = separation_of_leaves(pair, k, m, n, best - slack)
                if end == OVERLAP:
                    return OVERLAP, best, gap, a, b
                if end != BEYOND_CUTOFF and upper < best:
                    best, a, b = upper, x, y
            least = min(least, gap)
    return CLOSED, best, least, a, b


@inlined
def least_class(shape_A: Floats, tree_A: Tree, shape_B: Floats, tree_B: Tree) -> float:
    """Return the smallest class [m] that saves time: a part of the size of the trees' leaves.

    For smaller ones a walk ends at triangles all the same.
    """
    leaf_A = shape_A[tree_A.nodes + AREA] / tree_A.leaves
    leaf_B = shape_B[tree_B.nodes + AREA] / tree_B.leaves
    return OF_A_LEAF * math.sqrt(math.sqrt(leaf_A * leaf_B))


@allocating
def within_class(pair: SolidPair, length: float, a: Vector, b: Vector) -> Coarse:
    """Return the nearest points to a class, from points a and b of the surfaces."""
    A, B, best, least = pair.A, pair.B, norm(sub(b, a)), math.inf
    coins = coins_at(A.shape, A.tree), coins_at(B.shape, B.tree)
    path = Walk(np.zeros((DEEPEST, 2), dtype=np.int64), np.empty(DEEPEST))
    path.separations[0] = separation_of_coins(
        posed_coin(A, coins[0], pair.p, 0), coin_of_node(B.shape, coins[1], 0)
    )
    top, end, slack = 1, CLOSED, length - 4.0 * noise_of(pair)
    while top > 0 and end != OVERLAP:
        top -= 1
        i, j, gap = path.stack[top, 0], path.stack[top, 1], path.separations[top]
        if gap > best - slack:
            least = min(least, gap)
            continue
        both = posed_coin(A, coins[0], pair.p, i), coin_of_node(B.shape, coins[1], j)
        gap = max(gap, separation_beside(both[0], both[1]))
        if gap <= best - slack and (is_thick(both[0]) or is_thick(both[1])):
            box = box_of_node(A.shape, A.tree, i), box_of_node(B.shape, B.tree, j)
            gap = max(gap, separation_of_turned_boxes(box[0], A.R, pair.p, box[1]))
        if gap > best - slack:
            least = min(least, gap)
        elif is_leaf(A.tree, i) and is_leaf(B.tree, j):
            leaves = i - (A.tree.leaves - 1), j - (B.tree.leaves - 1)
            end, upper, gap, x, y = _nearer_in_leaves(pair, *leaves, best, slack)
            if upper < best:
                best, a, b = upper, x, y
            least = min(least, gap)
        else:
            top = _push_children(pair, coins, (i, j), both, path, top)
    least = min(least, best)
    is_apart = end != OVERLAP and least > noise_of(pair)
    lower = min(least, best - 0.5 * length)
    return Coarse(length, is_apart, Nearest(end, best, lower, unit(sub(b, a)), a, b, False))


@allocating
def coarse_nearest(pair: SolidPair, accuracy: float) -> Coarse:
    """Return the nearest points of two solids to an accuracy [m], or class 0.

    Class 0 is of bodies that do not seem to be apart, of accuracies below COARSE or too fine for
    the meshes to gain, and of solids with several surfaces, one of which could be around the other
    body. Of two single surfaces that do not cross, none is within the other body if a point of
    each is outside it.
    """
    nothing = Nearest(CLOSED, math.inf, 0.0, (1.0, 0.0, 0.0), pair.p, pair.p, False)
    A, B = pair.A, pair.B
    if accuracy < COARSE or A.kind != SOLID or A.tree.pieces > 1 or B.tree.pieces > 1:
        return Coarse(0.0, False, nothing)
    least = max(
        least_class(A.shape, A.tree, B.shape, B.tree), ROUNDINGS_OF_A_CLASS * noise_of(pair)
    )
    if class_of(accuracy) < least:
        return Coarse(0.0, False, nothing)
    are_outside, a, b = projected(pair)
    length = class_of(min(accuracy, SHARE * norm(sub(b, a)))) if are_outside else 0.0
    if length < least:
        return Coarse(0.0, False, nothing)
    return within_class(pair, length, a, b)
