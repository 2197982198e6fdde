"""Branch and bound over the tree of a map, or over those of two: the nearest, or deepest, cells.

Every pair of leaves that may be the best one is answered by the kernel of the pair table for a
box or a ball, from nothing: what was found before only leaves others out. Of cells that are as
near to the last digit the one of lesser coordinates is told, so neither the order in which cells
were given nor that of the walk is in an answer.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.extremes import (
    at_one_metre,
    is_extreme,
    vanishes,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
    Aim,
    OrientedShape,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.sensed.bodies import (
    Between,
    MapBody,
    MapPair,
    between,
    box_of_cell,
    box_of_node,
    centre_of,
    least_apart,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import first_in, is_leaf
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    norm,
    rotate,
    sub,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CONVEX
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

# What a walk found, in one array: the row of the best leaf, as a kernel writes it but measured
# from Ao, and then
OTHER = PAIR_WIDTH  # the least distance [m] of a leaf with another normal,
LEAST = OTHER + 1  # no more than the distance of any leaf that was asked [m],
SKIPPED = OTHER + 2  # nor of any that was left out [m],
CENTRES = OTHER + 3  # 6: and the places of the best leaves of B and of A
FOUND_WIDTH = CENTRES + 6

# Of a walk: each step takes one pair of nodes away and puts two back, and trees of 2^40 leaves do
# not fit into memory.
DEEPEST = 96


@allocating
def _call(pair: MapPair, c_A: Vector, c_B: Vector, p: Vector, limit: float, out: Floats) -> None:
    """Write the row of a leaf of A and a leaf of B, by their centres in A and in B.

    ``out`` has two rows: the second is where the kernel is told what is between the leaves. ``p``
    is Bo from Ao in World axes.
    """
    A, B = pair.A, pair.B
    from_A = rotate(A.R_W, c_A)
    between = sub(add(p, rotate(B.R_W, c_B)), from_A)
    first = A.leaf_kind <= B.leaf_kind
    sign = 1.0 if first else -1.0
    told, apart = row(out, 0), row(out, 1)
    for k in range(3):
        told[NORMAL + k], apart[k] = 0.0, sign * between[k]
    aim = Aim(A.reach + B.reach, pair.aim.tolerance, limit)
    mine = OrientedShape(A.leaf_kind, A.leaf, A.R_W)
    its = OrientedShape(B.leaf_kind, B.leaf, B.R_W)
    if not first:
        mine, its = its, mine
    extreme = is_extreme(aim.size, apart) or vanishes(A.leaf_kind, A.leaf)
    if extreme and its.kind <= CONVEX:
        at_one_metre(pair.address, mine, its, part(apart, 0, 3), aim, told)
    else:
        call_kernel(pair.address, mine, its, part(apart, 0, 3), aim, told)
    base = from_A if first else add(from_A, between)
    for k in range(3):
        a, b = base[k] + told[WITNESS_A + k], base[k] + told[WITNESS_B + k]
        told[WITNESS_A + k], told[WITNESS_B + k] = (a, b) if first else (b, a)
        told[NORMAL + k] *= sign


@compiled
def _is_before(c_A: Vector, c_B: Vector, found: Floats) -> bool:
    """Tell whether leaves have lesser coordinates than those found."""
    for k in range(6):
        mine = c_B[k] if k < 3 else c_A[k - 3]
        if mine != found[CENTRES + k]:
            return mine < found[CENTRES + k]
    return False


@compiled
def _take(told: Floats, c_A: Vector, c_B: Vector, found: Floats) -> None:
    """Take the row of a leaf for the best, or note how near it is with another normal."""
    distance = told[DISTANCE]
    found[LEAST] = min(found[LEAST], distance - told[ERROR_BOUND])
    best = found[DISTANCE]
    differs = dot(vector_at(told, NORMAL), vector_at(found, NORMAL)) < SAME_DIRECTION
    if distance > best or (distance == best and not _is_before(c_A, c_B, found)):
        if differs:
            found[OTHER] = min(found[OTHER], distance)
        return
    if differs:
        found[OTHER] = min(found[OTHER], best)
    for c in range(PAIR_WIDTH):
        found[c] = told[c]
    for k in range(3):
        found[CENTRES + k], found[CENTRES + 3 + k] = c_B[k], c_A[k]


@allocating
def _look_at_leaves(
    pair: MapPair,
    at: Between,
    nodes: tuple[int, int],
    p: Vector,
    cutoff: float,
    found: Floats,
    room: Floats,
) -> None:
    """Ask about the cells of a leaf of A's tree and of one of B's."""
    A, B, noise = pair.A, pair.B, noise_of(pair)
    i, j = nodes
    for a in range(first_in(A.tree, i), first_in(A.tree, i + 1)):
        box = box_of_cell(A, a)
        for b in range(first_in(B.tree, j), first_in(B.tree, j + 1)):
            limit = min(cutoff, found[DISTANCE])
            least = least_apart(at, box, box_of_cell(B, b), limit + noise) - noise
            if least > limit:
                found[SKIPPED] = min(found[SKIPPED], least)
                continue
            c_A, c_B = centre_of(A, a), centre_of(B, b)
            _call(pair, c_A, c_B, p, max(limit, 0.0) + noise, room)
            if room[0, METHOD] == BOUND_ONLY:
                found[SKIPPED] = min(found[SKIPPED], max(least, room[0, DISTANCE] - noise))
            elif room[0, DISTANCE] - room[0, ERROR_BOUND] > cutoff:
                found[SKIPPED] = min(found[SKIPPED], room[0, DISTANCE] - room[0, ERROR_BOUND])
            else:
                _take(row(room, 0), c_A, c_B, found)


class Path(NamedTuple):
    """The stack of a walk: pairs of nodes (k, 2), and lower bounds of their distances [m]."""

    stack: Indices
    least: Floats


@inlined
def _cuts_B(A: MapBody, B: MapBody, i: int, j: int) -> bool:
    """Tell whether it is B's node j that is cut in two, and not A's node i."""
    if is_leaf(A.tree, i) or is_leaf(B.tree, j):
        return is_leaf(A.tree, i)
    return norm(box_of_node(B, j).half) >= norm(box_of_node(A, i).half)


@inlined
def _push_children(
    pair: MapPair, at: Between, nodes: tuple[int, int], path: Path, top: int, limit: float
) -> int:
    """Push the two pairs that a pair of nodes, not both leaves, is cut into, the nearer last."""
    A, B = pair.A, pair.B
    i, j = nodes
    cut_B = _cuts_B(A, B, i, j)
    for turn in range(2):
        mine = i if cut_B else 2 * i + 1 + turn
        its = 2 * j + 1 + turn if cut_B else j
        path.stack[top + turn, 0], path.stack[top + turn, 1] = mine, its
        boxes = box_of_node(A, mine), box_of_node(B, its)
        path.least[top + turn] = least_apart(at, boxes[0], boxes[1], limit)
    if path.least[top] < path.least[top + 1]:
        for k in range(2):
            path.stack[top, k], path.stack[top + 1, k] = path.stack[top + 1, k], path.stack[top, k]
        path.least[top], path.least[top + 1] = path.least[top + 1], path.least[top]
    return top + 2


@allocating
def find_nearest(pair: MapPair, p: Vector, cutoff: float, found: Floats) -> None:
    """Write into ``found`` (FOUND_WIDTH,) which leaves are nearest, or deepest.

    ``p`` [m] is Bo from Ao in World axes. Of leaves beyond the cutoff [m] it is only told what
    they are apart at least; its DISTANCE is infinite where there are no others.

    No leaves that are the best are left out: a pair of nodes is put aside only if a lower bound of
    all leaves below is beyond the best one, and otherwise both its halves take its place.
    """
    found[:] = 0.0
    found[DISTANCE] = found[OTHER] = found[LEAST] = found[SKIPPED] = math.inf
    path = Path(np.zeros((DEEPEST, 2), np.int64), np.empty(DEEPEST))
    room, noise, at = np.zeros((2, PAIR_WIDTH)), noise_of(pair), between(pair, p)
    path.least[0], top = -math.inf, 1
    while top > 0:
        top -= 1
        nodes = path.stack[top, 0], path.stack[top, 1]
        limit = min(cutoff, found[DISTANCE]) + noise
        if path.least[top] > limit:
            found[SKIPPED] = min(found[SKIPPED], path.least[top] - noise)
        elif is_leaf(pair.A.tree, nodes[0]) and is_leaf(pair.B.tree, nodes[1]):
            _look_at_leaves(pair, at, nodes, p, cutoff, found, room)
        else:
            top = _push_children(pair, at, nodes, path, top, limit)
