"""Nearest cells of two leaves of trees: kernel calls for their cells, and the best result.

Every pair of cells that may be the best is answered by the pair table's kernel for a box or ball,
without a hint: earlier results only exclude others. Among equally near cells the one with the
least coordinates is returned, so the answer does not depend on the order of the input. Below a
face that is flush with a floor of cells, all cells are equally near along one normal. The plane of
the best one detects that, and then only cells with lesser coordinates are examined.
"""

from __future__ import annotations

import math
from typing import NamedTuple

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
    box_of_cell,
    centre_of,
    least_apart,
    noise_of,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import first_in
from drake_geom_ros.geometry._proximity.kernels.shapes.supports import local_support
from drake_geom_ros.geometry._proximity.kernels.vectors import (
    add,
    dot,
    rotate,
    scale,
    sub,
    unrotate,
    vector_at,
)
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CONVEX, HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import SAME_DIRECTION

# Result of a walk, in one array: the row of the best leaf, as a kernel writes it but measured from
# Ao, and then
OTHER = PAIR_WIDTH  # the least distance [m] of a leaf with another normal,
LEAST = OTHER + 1  # a lower bound of the distances of all examined leaves [m],
SKIPPED = OTHER + 2  # and of all excluded leaves [m],
CENTRES = OTHER + 3  # 6: the centres of the best leaves of B and of A,
PLANE = CENTRES + 6  # 4: the unit normal from A to B there, in B, and the leaves' reach along it
NEAREST_WIDTH = PLANE + 4

# A leaf beyond the plane of the best one, within rounding, that is farther by no more than the
# bounds leave open has a normal within SAME_DIRECTION of the best one's, if the distance is at
# least this many times that: gaps along a direction are shorter than the distance by the cosine.
FLUSH = 128.0


@allocating
def _call(pair: MapPair, c_A: Vector, c_B: Vector, p: Vector, limit: float, out: Floats) -> None:
    """Write the row of a leaf of A and a leaf of B, by their centres in A and in B.

    ``out`` has two rows: the second passes the offset of the leaves to the kernel. ``p`` is Bo
    from Ao in World axes.
    """
    A, B = pair.A, pair.B
    from_A = rotate(A.R_W, c_A)
    between = sub(add(p, rotate(B.R_W, c_B)), from_A)
    first = A.leaf_kind <= B.leaf_kind
    sign = 1.0 if first else -1.0
    answer, apart = row(out, 0), row(out, 1)
    for k in range(3):
        answer[NORMAL + k], apart[k] = 0.0, sign * between[k]
    aim = Aim(A.reach + B.reach, pair.aim.tolerance, limit, 0.0)
    leaf_A = OrientedShape(A.leaf_kind, A.leaf, A.R_W)
    leaf_B = OrientedShape(B.leaf_kind, B.leaf, B.R_W)
    if not first:
        leaf_A, leaf_B = leaf_B, leaf_A
    extreme = is_extreme(aim.size, apart) or vanishes(A.leaf_kind, A.leaf)
    if extreme and leaf_B.kind <= CONVEX:
        at_one_metre(pair.address, leaf_A, leaf_B, part(apart, 0, 3), aim, answer)
    else:
        call_kernel(pair.address, leaf_A, leaf_B, part(apart, 0, 3), aim, answer)
    base = from_A if first else add(from_A, between)
    for k in range(3):
        a, b = base[k] + answer[WITNESS_A + k], base[k] + answer[WITNESS_B + k]
        answer[WITNESS_A + k], answer[WITNESS_B + k] = (a, b) if first else (b, a)
        answer[NORMAL + k] *= sign


@compiled
def _is_before(c_A: Vector, c_B: Vector, nearest: Floats) -> bool:
    """Return whether leaves have lesser coordinates than the best ones."""
    for k in range(6):
        coordinate = c_B[k] if k < 3 else c_A[k - 3]
        if coordinate != nearest[CENTRES + k]:
            return coordinate < nearest[CENTRES + k]
    return False


@inlined
def _reach(body: MapBody, n: Vector) -> float:
    """Return the support value [m] of a leaf along n from its centre, in the body's frame."""
    core = 0.0
    if body.tree.leaves == 0:
        kind = CONVEX if body.kind == SOLID else body.kind
        core = dot(local_support(kind, body.shape, n, 0.0), n)
    return core + body.half * (abs(n[0]) + abs(n[1]) + abs(n[2])) + body.radius


@compiled
def _put_plane(pair: MapPair, at: Between, nearest: Floats) -> None:
    """Write the plane of the best leaves, beyond A's leaf; infinitely far for a half space."""
    A, B, n = pair.A, pair.B, scale(-1.0, vector_at(nearest, NORMAL))
    in_B = unrotate(B.R_W, n)
    for k in range(3):
        nearest[PLANE + k] = in_B[k]
    nearest[PLANE + 3] = math.inf
    if A.kind != HALF_SPACE:
        reach = _reach(A, unrotate(A.R_W, n)) + _reach(B, in_B)
        nearest[PLANE + 3] = dot(in_B, at.p) + reach


@inlined
def _beyond_plane(pair: MapPair, at: Between, c_A: Vector, c_B: Vector, nearest: Floats) -> float:
    """Return a lower bound [m] of the distance of leaves from the plane of the best ones.

    It is minus infinity where leaves with another normal could be as near.
    """
    noise = noise_of(pair)
    if not FLUSH * (noise + 2.0 * nearest[ERROR_BOUND]) < nearest[DISTANCE] < math.inf:
        return -math.inf
    n = vector_at(nearest, PLANE)
    return dot(n, sub(c_B, rotate(at.R, c_A))) - nearest[PLANE + 3] - noise


@compiled
def _take(answer: Floats, c_A: Vector, c_B: Vector, nearest: Floats) -> bool:
    """Take the row of a leaf if it is the best, or record its distance if its normal differs.

    Return whether it is the best.
    """
    distance = answer[DISTANCE]
    nearest[LEAST] = min(nearest[LEAST], distance - answer[ERROR_BOUND])
    best = nearest[DISTANCE]
    differs = dot(vector_at(answer, NORMAL), vector_at(nearest, NORMAL)) < SAME_DIRECTION
    if distance > best or (distance == best and not _is_before(c_A, c_B, nearest)):
        if differs:
            nearest[OTHER] = min(nearest[OTHER], distance)
        return False
    if differs:
        nearest[OTHER] = min(nearest[OTHER], best)
    for c in range(PAIR_WIDTH):
        nearest[c] = answer[c]
    for k in range(3):
        nearest[CENTRES + k], nearest[CENTRES + 3 + k] = c_B[k], c_A[k]
    return True


class LeafScratch(NamedTuple):
    """Scratch arrays of ``look_at_leaves``."""

    rows: Floats  # (2, PAIR_WIDTH) see ``_call``
    least: Floats  # (MOST_IN_LEAF^2,) lower bounds of the distances of cells [m]


@allocating
def _examine(
    pair: MapPair,
    at: Between,
    cells: tuple[int, int],
    p: Vector,
    limits: tuple[float, float],
    nearest: Floats,
    rows: Floats,
) -> None:
    """Examine a cell of A and one of B; ``limits`` are a lower bound [m] and the cutoff [m]."""
    noise, (least, cutoff) = noise_of(pair), limits
    c_A, c_B = centre_of(pair.A, cells[0]), centre_of(pair.B, cells[1])
    beyond = _beyond_plane(pair, at, c_A, c_B, nearest)
    farther = nearest[DISTANCE] - beyond
    if farther < 0.0 or (farther <= 2.0 * noise and not _is_before(c_A, c_B, nearest)):
        nearest[LEAST] = min(nearest[LEAST], beyond)
        return
    _call(pair, c_A, c_B, p, max(min(cutoff, nearest[DISTANCE]), 0.0) + noise, rows)
    if rows[0, METHOD] == BOUND_ONLY:
        nearest[SKIPPED] = min(nearest[SKIPPED], max(least, rows[0, DISTANCE] - noise))
    elif rows[0, DISTANCE] - rows[0, ERROR_BOUND] > cutoff:
        nearest[SKIPPED] = min(nearest[SKIPPED], rows[0, DISTANCE] - rows[0, ERROR_BOUND])
    elif _take(row(rows, 0), c_A, c_B, nearest):
        _put_plane(pair, at, nearest)


@allocating
def look_at_leaves(
    pair: MapPair,
    at: Between,
    nodes: tuple[int, int],
    p: Vector,
    cutoff: float,
    nearest: Floats,
    scratch: LeafScratch,
) -> None:
    """Examine the cells of a leaf of A's tree and one of B's, the nearest first."""
    A, B, noise = pair.A, pair.B, noise_of(pair)
    a, b = first_in(A.tree, nodes[0]), first_in(B.tree, nodes[1])
    count_A = first_in(A.tree, nodes[0] + 1) - a
    count_B = first_in(B.tree, nodes[1] + 1) - b
    limit, count = min(cutoff, nearest[DISTANCE]) + noise, count_A * count_B
    for k in range(count):
        boxes = box_of_cell(A, a + k // count_B), box_of_cell(B, b + k % count_B)
        scratch.least[k] = least_apart(at, boxes[0], boxes[1], limit) - noise
    for _ in range(count):
        k = 0
        for other in range(1, count):
            if scratch.least[other] < scratch.least[k]:
                k = other
        least = scratch.least[k]
        if least > min(cutoff, nearest[DISTANCE]):
            nearest[SKIPPED] = min(nearest[SKIPPED], least)
            return
        scratch.least[k] = math.inf
        cells = a + k // count_B, b + k % count_B
        _examine(pair, at, cells, p, (least, cutoff), nearest, scratch.rows)
