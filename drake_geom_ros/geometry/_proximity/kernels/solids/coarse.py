"""Distance from a solid to an accuracy that is wanted: points above, hulls or coins below.

Two points of the surfaces bound the distance from above, and they are found first: each is the
nearest on its surface to the other (alternating projections, von Neumann), to less than the
accuracy. The gap between the convex hulls along the line of these points bounds it from below.
Where neither body reaches into a dent of the other, that is nearly their distance, for a hundredth
of the time. Elsewhere the coins of two trees' nodes bound it: a walk leaves out what is farther
than the best two points less the accuracy, and looks at triangles only where coins do not decide.
Where a millimetre is wanted, this is most of a mesh of 20 000 triangles, and all of it where a
centimetre is.

Beside a core the gap from the solid's hull comes first, with the point of the core that is nearest
to the hull; the surface's nearest point to that bounds the distance from above. Where this does
not decide, ``exact`` answers: a core is a single leaf, and coins would not gain.

The accuracy is rounded down to a power of 2, a *class*, and to half of the distance of the first
two points, so that small gaps are seen. Bounds are widened to half the class where they are
narrower: so no larger accuracy has narrower ones by luck. Bodies are given as in ``distance``.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.cores.gjk import (
    BEYOND_CUTOFF,
    CLOSED,
    OVERLAP,
    distance_of_cores,
)
from drake_geom_ros.geometry._proximity.kernels.cores.records import CorePair
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import hull_defect
from drake_geom_ros.geometry._proximity.kernels.solids.coins import (
    Coin,
    coin_of_node,
    coins_at,
    is_thick,
    posed_coin,
    separation_of_coins,
)
from drake_geom_ros.geometry._proximity.kernels.solids.distance import Nearest
from drake_geom_ros.geometry._proximity.kernels.solids.hulls import width_of_hulls
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
    scale,
    sub,
    unit,
    unrotate,
    vector_in,
)
from drake_geom_ros.geometry._proximity.kinds import CONVEX, SOLID, SPHERE
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


@inlined
def class_for(length: float, least: float) -> float:
    """Return the class of a length [m], 0 where it is below ``least``."""
    found = class_of(length) if length > 0.0 else 0.0
    return found if found >= least else 0.0


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


@inlined
def slack_of(pair: SolidPair, length: float) -> float:
    """Return by how much [m] bounds may be apart for a class."""
    return length - 4.0 * noise_of(pair)


class Projected(NamedTuple):
    """Points a and b of the surfaces of A and B, each the nearest to the other, or nearly.

    They are wanted to a class of ``length`` [m], 0 where no class fits. The hulls are apart by
    ``gap`` along their line, which decides if ``by_hulls``. ``q`` is a point of B, in A; ``of_A``
    and ``on_A`` are the triangles of A nearest to it as ``project`` has them, ``of_B`` and
    ``on_B`` those of B nearest to a.
    """

    a: Vector
    b: Vector
    length: float
    gap: float
    by_hulls: bool
    q: Vector
    of_A: int
    on_A: PointScratch
    of_B: int
    on_B: PointScratch


@allocating
def projected(pair: SolidPair, accuracy: float, least: float) -> Projected:
    """Return nearly the nearest points of two surfaces; others may be nearer.

    The class for an ``accuracy`` [m] is no less than ``least`` [m]. Projecting ends where the
    hulls show that points are near enough.
    """
    A, B, p, R = pair.A, pair.B, pair.p, pair.A.R
    on_A, on_B = (
        scratch_for(lane_tree_of(A.tree), FEW),
        scratch_for(lane_tree_of(B.tree), FEW),
    )
    b, of_B, on_B = project(
        B.shape, B.tree, add(rotate(R, box_of_node(A.shape, A.tree, 0).middle), p), on_B
    )
    a, q, of_A, before, length, gap, by_hulls = b, b, 0, math.inf, 0.0, 0.0, False
    for _ in range(MOST_PROJECTIONS):
        q = unrotate(R, sub(b, p))
        x, of_A, on_A = project(A.shape, A.tree, q, on_A)
        a = add(rotate(R, x), p)
        b, of_B, on_B = project(B.shape, B.tree, a, on_B)
        d = norm(sub(b, a))
        length = class_for(min(accuracy, SHARE * d), least)
        if length > 0.0:
            gap = -width_of_hulls(pair, unit(sub(a, b)), 0.0)
            by_hulls = gap >= d - slack_of(pair, length)
        if by_hulls or d > (1.0 - GAIN) * before:
            break
        before = d
    return Projected(a, b, length, gap, by_hulls, q, of_A, on_A, of_B, on_B)


@compiled
def are_outside(pair: SolidPair, found: Projected) -> bool:
    """Return whether a point of each surface is certified to be outside the other body."""
    A, B = pair.A, pair.B
    if not is_outside(A.shape, A.tree, found.q, found.of_A, found.on_A):
        return False
    return is_outside(B.shape, B.tree, found.a, found.of_B, found.on_B)


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
    """Return the smallest class [m] for which coins save time: a part of the size of leaves.

    For smaller ones a walk ends at triangles all the same.
    """
    leaf_A = shape_A[tree_A.nodes + AREA] / tree_A.leaves
    leaf_B = shape_B[tree_B.nodes + AREA] / tree_B.leaves
    return OF_A_LEAF * math.sqrt(math.sqrt(leaf_A * leaf_B))


@compiled
def to_class(length: float, end: int, least: float, best: float, a: Vector, b: Vector) -> Nearest:
    """Return points a and b, ``best`` apart, as the nearest to a class, which least bounds."""
    lower = min(least, best - 0.5 * length)
    return Nearest(end, best, lower, unit(sub(b, a)), a, b, False)


@allocating
def within_class(pair: SolidPair, length: float, a: Vector, b: Vector) -> Coarse:
    """Return the nearest points to a class, from points a and b of the surfaces."""
    A, B, best, least = pair.A, pair.B, norm(sub(b, a)), math.inf
    coins = coins_at(A.shape, A.tree), coins_at(B.shape, B.tree)
    path = Walk(np.zeros((DEEPEST, 2), dtype=np.int64), np.empty(DEEPEST))
    path.separations[0] = separation_of_coins(
        posed_coin(A, coins[0], pair.p, 0), coin_of_node(B.shape, coins[1], 0)
    )
    top, end, slack = 1, CLOSED, slack_of(pair, length)
    while top > 0 and end != OVERLAP:
        top -= 1
        i, j, gap = path.stack[top, 0], path.stack[top, 1], path.separations[top]
        if gap > best - slack:
            least = min(least, gap)
            continue
        both = posed_coin(A, coins[0], pair.p, i), coin_of_node(B.shape, coins[1], j)
        if is_thick(both[0]) or is_thick(both[1]):
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
    return Coarse(length, is_apart, to_class(length, end, least, best, a, b))


@inlined
def nothing_coarse(pair: SolidPair) -> Coarse:
    """Return class 0, for which the kernel of ``exact`` answers."""
    nothing = Nearest(CLOSED, math.inf, 0.0, (1.0, 0.0, 0.0), pair.p, pair.p, False)
    return Coarse(0.0, False, nothing)


@allocating
def nearest_to_core(pair: SolidPair, n: Vector, accuracy: float, least: float) -> Coarse:
    """Return the nearest points of a core and a solid to an accuracy [m], or class 0.

    The class is no less than ``least`` [m], and half of the distance of the grown core at most.
    GJK starts from the unit n. Where A is grown by a ball, its point has to be the nearest to that
    of B, for else the ball's is within A.
    """
    A, B, p = pair.A, pair.B, pair.p
    to_hull = CorePair(A.kind, A.shape, A.R, CONVEX, B.shape, B.identity, scale(-1.0, p))
    found = distance_of_cores(to_hull, n, pair.size, pair.tolerance, math.inf)
    if found.end == OVERLAP or found.lower <= pair.radius:
        return nothing_coarse(pair)
    gap = found.lower - (hull_defect(A.shape) if A.kind == CONVEX else 0.0)
    a = add(p, found.a)
    b, _, _ = project(B.shape, B.tree, a, scratch_for(lane_tree_of(B.tree), FEW))
    if pair.radius > 0.0:
        to_point = CorePair(A.kind, A.shape, A.R, SPHERE, B.shape, B.identity, sub(b, p))
        back = distance_of_cores(to_point, found.n, pair.size, pair.tolerance, math.inf)
        a = add(p, back.a)
    best = norm(sub(b, a))
    length = class_for(min(accuracy, SHARE * (best - pair.radius)), least)
    if length == 0.0 or gap < best - slack_of(pair, length):
        return nothing_coarse(pair)
    return Coarse(length, True, to_class(length, CLOSED, gap, best, a, b))


@allocating
def coarse_nearest(pair: SolidPair, n: Vector, accuracy: float) -> Coarse:
    """Return the nearest points of a core or a solid and a solid to an accuracy [m], or class 0.

    Class 0 is of bodies that do not seem to be apart, and of accuracies below COARSE. Where hulls
    do not decide it is also of cores, of accuracies too fine for coins to gain, and of solids with
    several surfaces, one of which could be around the other body. Of two single surfaces that do
    not cross, none is within the other body if a point of each is outside it. The search beside a
    core starts from the unit n.
    """
    A, B = pair.A, pair.B
    least = ROUNDINGS_OF_A_CLASS * noise_of(pair)
    if accuracy < COARSE or class_for(accuracy, least) == 0.0:
        return nothing_coarse(pair)
    if A.kind != SOLID:
        return nearest_to_core(pair, n, accuracy, least)
    found = projected(pair, accuracy, least)
    length = found.length
    if found.by_hulls:
        best = norm(sub(found.b, found.a))
        return Coarse(length, True, to_class(length, CLOSED, found.gap, best, found.a, found.b))
    least = max(least, least_class(A.shape, A.tree, B.shape, B.tree))
    has_more = A.tree.pieces > 1 or B.tree.pieces > 1
    if length < least or has_more or not are_outside(pair, found):
        return nothing_coarse(pair)
    nearer = within_class(pair, length, found.a, found.b)
    while not nearer.is_apart and nearer.closest.end != OVERLAP:
        # It found points nearer than the class, so a smaller one may show that there is a gap.
        _, best, _, _, a, b, _ = nearer.closest
        smaller = class_for(SHARE * best, least)
        if smaller == 0.0:
            break
        nearer = within_class(pair, smaller, a, b)
    end, best, lower, _, a, b, _ = nearer.closest
    return Coarse(length, nearer.is_apart, to_class(length, end, lower, best, a, b))
