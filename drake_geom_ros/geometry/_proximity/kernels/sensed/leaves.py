"""Which cells of two leaves of trees are nearest: what is asked about them, and kept of that.

Every pair of cells that may be the best one is answered by the kernel of the pair table for a
box or a ball, from nothing: what was found before only leaves others out. Of cells that are as
near the one of lesser coordinates is told, so the order in which cells were given is not in an
answer. Below a face that lies flush with a floor of cells all are as near, and along one normal:
the plane of the best one tells so, and of these only the ones of lesser coordinates are asked.
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

# What a walk found, in one array: the row of the best leaf, as a kernel writes it but measured
# from Ao, and then
OTHER = PAIR_WIDTH  # the least distance [m] of a leaf with another normal,
LEAST = OTHER + 1  # no more than the distance of any leaf that was asked [m],
SKIPPED = OTHER + 2  # nor of any that was left out [m],
CENTRES = OTHER + 3  # 6: and the places of the best leaves of B and of A,
PLANE = CENTRES + 6  # 4: and the unit way from A to B there, in B, and how far leaves reach on it
FOUND_WIDTH = PLANE + 4

# A leaf beyond the plane of the best one, to a rounding, that is farther away by no more than
# what bounds leave open, has a normal within SAME_DIRECTION of the best one's if the distance is
# so many times that: gaps along a direction are shorter than the distance by the cosine.
FLUSH = 128.0


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


@inlined
def _reach(body: MapBody, n: Vector) -> float:
    """Return how far a leaf of a body reaches along n [m], both in its frame, from its centre."""
    core = 0.0
    if body.tree.leaves == 0:
        kind = CONVEX if body.kind == SOLID else body.kind
        core = dot(local_support(kind, body.shape, n, 0.0), n)
    return core + body.half * (abs(n[0]) + abs(n[1]) + abs(n[2])) + body.radius


@compiled
def _put_plane(pair: MapPair, at: Between, found: Floats) -> None:
    """Write the plane of the best leaves, which A's does not cross; a half space has none."""
    A, B, n = pair.A, pair.B, scale(-1.0, vector_at(found, NORMAL))
    in_B = unrotate(B.R_W, n)
    for k in range(3):
        found[PLANE + k] = in_B[k]
    found[PLANE + 3] = math.inf
    if A.kind != HALF_SPACE:
        reach = _reach(A, unrotate(A.R_W, n)) + _reach(B, in_B)
        found[PLANE + 3] = dot(in_B, at.p) + reach


@inlined
def _beyond_plane(pair: MapPair, at: Between, c_A: Vector, c_B: Vector, found: Floats) -> float:
    """Return a lower bound [m] of the distance of leaves, which that of the best ones gives.

    Minus infinity where leaves of another normal could be as near, for all that it says.
    """
    noise = noise_of(pair)
    if not FLUSH * (noise + 2.0 * found[ERROR_BOUND]) < found[DISTANCE] < math.inf:
        return -math.inf
    n = vector_at(found, PLANE)
    return dot(n, sub(c_B, rotate(at.R, c_A))) - found[PLANE + 3] - noise


@compiled
def _take(told: Floats, c_A: Vector, c_B: Vector, found: Floats) -> bool:
    """Take the row of a leaf for the best, or note how near it is with another normal.

    Return whether it is the best.
    """
    distance = told[DISTANCE]
    found[LEAST] = min(found[LEAST], distance - told[ERROR_BOUND])
    best = found[DISTANCE]
    differs = dot(vector_at(told, NORMAL), vector_at(found, NORMAL)) < SAME_DIRECTION
    if distance > best or (distance == best and not _is_before(c_A, c_B, found)):
        if differs:
            found[OTHER] = min(found[OTHER], distance)
        return False
    if differs:
        found[OTHER] = min(found[OTHER], best)
    for c in range(PAIR_WIDTH):
        found[c] = told[c]
    for k in range(3):
        found[CENTRES + k], found[CENTRES + 3 + k] = c_B[k], c_A[k]
    return True


class Room(NamedTuple):
    """What is written and used at once."""

    rows: Floats  # (2, PAIR_WIDTH) see ``_call``
    least: Floats  # (MOST_IN_LEAF^2,) lower bounds of the distances of cells [m]


@allocating
def _ask(
    pair: MapPair,
    at: Between,
    cells: tuple[int, int],
    p: Vector,
    limits: tuple[float, float],
    found: Floats,
    rows: Floats,
) -> None:
    """Ask about a cell of A and one of B; limits: a lower bound [m] of theirs, and the cutoff."""
    noise, (least, cutoff) = noise_of(pair), limits
    c_A, c_B = centre_of(pair.A, cells[0]), centre_of(pair.B, cells[1])
    beyond = _beyond_plane(pair, at, c_A, c_B, found)
    farther = found[DISTANCE] - beyond
    if farther < 0.0 or (farther <= 2.0 * noise and not _is_before(c_A, c_B, found)):
        found[LEAST] = min(found[LEAST], beyond)
        return
    _call(pair, c_A, c_B, p, max(min(cutoff, found[DISTANCE]), 0.0) + noise, rows)
    if rows[0, METHOD] == BOUND_ONLY:
        found[SKIPPED] = min(found[SKIPPED], max(least, rows[0, DISTANCE] - noise))
    elif rows[0, DISTANCE] - rows[0, ERROR_BOUND] > cutoff:
        found[SKIPPED] = min(found[SKIPPED], rows[0, DISTANCE] - rows[0, ERROR_BOUND])
    elif _take(row(rows, 0), c_A, c_B, found):
        _put_plane(pair, at, found)


@allocating
def look_at_leaves(
    pair: MapPair,
    at: Between,
    nodes: tuple[int, int],
    p: Vector,
    cutoff: float,
    found: Floats,
    room: Room,
) -> None:
    """Ask about the cells of a leaf of A's tree and of one of B's, the nearest first."""
    A, B, noise = pair.A, pair.B, noise_of(pair)
    a, b = first_in(A.tree, nodes[0]), first_in(B.tree, nodes[1])
    count_A = first_in(A.tree, nodes[0] + 1) - a
    count_B = first_in(B.tree, nodes[1] + 1) - b
    limit, count = min(cutoff, found[DISTANCE]) + noise, count_A * count_B
    for k in range(count):
        boxes = box_of_cell(A, a + k // count_B), box_of_cell(B, b + k % count_B)
        room.least[k] = least_apart(at, boxes[0], boxes[1], limit) - noise
    for _ in range(count):
        k = 0
        for other in range(1, count):
            if room.least[other] < room.least[k]:
                k = other
        least = room.least[k]
        if least > min(cutoff, found[DISTANCE]):
            found[SKIPPED] = min(found[SKIPPED], least)
            return
        room.least[k] = math.inf
        cells = a + k // count_B, b + k % count_B
        _ask(pair, at, cells, p, (least, cutoff), found, room.rows)
