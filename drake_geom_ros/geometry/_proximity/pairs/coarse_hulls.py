"""Pairs that the coarse hulls of their bodies decide, or answer as well as is wanted.

A coarse hull is contained in the hull of its body, which extends beyond it by its *reach* at most.
So their support functions differ by no more than the reach, and the signed distance of two hulls
is that of their coarse hulls less 0 to the sum of both reaches. A coarse hull has 64 vertices,
which take a fraction of the time of thousands.

A solid is contained in its hull, so a lower bound of the distance of hulls is one of solids.
"""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.calling.extremes import is_extreme, vanishes
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    UNIQUE,
    WITNESS_A,
    WITNESS_B,
    Aim,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import coarse_hull_at
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kinds import BOUND_ONLY, CONVEX, HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.pairs.distance_bounds import apart
from drake_geom_ros.geometry._proximity.pairs.kernel_calls import (
    call_in_order,
    is_plain_overlap,
    overlaps_a_cell,
)
from drake_geom_ros.geometry._proximity.pairs.slots import ALL, Shapes
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part
from drake_geom_ros.geometry._proximity.tolerances import (
    COARSE,
    EPS,
    PLAIN_DEPTH,
    PROMISED_ROUNDING,
    ROUNDING,
)

# Verdicts of ``by_coarse_hulls``.
UNDECIDED, ANSWERED, HIT = 0, 1, 2
# Share of a distance [-] that reaches may be where the direction is unique: then it is less than
# 8 degrees off. Points x of a convex set nearest to the origin, and y of one around it whose
# distance is less by r, have |x - y|^2 <= |x|^2 - |y|^2 <= 2 |x| r.
SMALL_REACH = 2.0**-7


@inlined
def may_decide(type_a: int, type_b: int, enough: float, accuracy: float) -> bool:
    """Return whether the coarse hulls of two types may decide, at an accuracy [m]."""
    most = max(type_a, type_b)
    if most < CONVEX or most > SOLID or type_a == HALF_SPACE or type_b == HALF_SPACE:
        return False
    return enough > ALL or most == SOLID or accuracy >= COARSE


@inlined
def _reach(k: int, shapes: Shapes) -> float:
    """Return how far [m] shape k may be beyond its coarse hull, 0 without one."""
    shape = part(shapes.pool, shapes.starts[k], shapes.starts[k + 1])
    at = coarse_hull_at(shape) if shapes.types[k] >= CONVEX else 0
    return shape[at] if at > 0 else 0.0


@inlined
def _write_between(
    now: Floats, reaches: tuple[float, float], lower: float, error: float, out: Floats
) -> None:
    """Write the answer in the middle of what the coarse hulls leave open.

    The witness points move out of the coarse hulls by half of their reaches.
    """
    for c in range(PAIR_WIDTH):
        out[c] = now[c]
    out[DISTANCE] -= 0.5 * (reaches[0] + reaches[1])
    out[ERROR_BOUND] = error
    if lower < (reaches[0] + reaches[1]) / SMALL_REACH:
        out[UNIQUE] = 0.0
    for c in range(3):
        out[WITNESS_A + c] -= 0.5 * reaches[0] * now[NORMAL + c]
        out[WITNESS_B + c] += 0.5 * reaches[1] * now[NORMAL + c]


@allocating
def by_coarse_hulls(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    aim: Aim,
    enough: float,
    out: Floats,
) -> int:
    """Return HIT, or ANSWERED with the answer in ``out``, or UNDECIDED.

    ``enough`` [m] is that of ``slots.Search``.

    - Beyond the cutoff of ``aim``, by more than ``exact`` may be off, the answer is the bound
      alone.
    - Where one pair will do, one that ``exact`` reports within ``enough`` for certain is a HIT;
      nothing of it is stored.
    - Else the answer is written if its error is within the accuracy of ``aim``, and if it is
      certain whether the bodies overlap.
    """
    has_solid = max(shapes.types[a], shapes.types[b]) == SOLID
    reach_a, reach_b = _reach(a, shapes), _reach(b, shapes)
    reach, wanted = reach_a + reach_b, 0.0
    if enough == ALL and not has_solid:
        wanted = aim.accuracy
        if 0.5 * reach > wanted:
            return UNDECIDED
    if (reach == 0.0 and not has_solid) or (has_solid and aim.cutoff == math.inf):
        return UNDECIDED
    for c in range(3):
        p_AB_W[c] = poses[1][b, c] - poses[1][a, c]
    extreme = is_extreme(aim.size, p_AB_W)
    for k in (a, b):
        shape = part(shapes.pool, shapes.starts[k], shapes.starts[k + 1])
        extreme = extreme or vanishes(shapes.types[k], shape)
    if extreme:
        return UNDECIDED
    extent = aim.size + apart(poses[1], a, b)
    promised = aim.tolerance + PROMISED_ROUNDING * EPS * extent
    # A solid may be deeper in another body than its hull is.
    far = (max(aim.cutoff, 0.0) if has_solid else aim.cutoff) + 2.0 * promised
    cutoff = far + reach
    now = np.zeros(PAIR_WIDTH)
    for c in range(3):
        now[NORMAL + c] = out[NORMAL + c]
    coarse_aim = Aim(aim.size, aim.tolerance, cutoff, aim.tolerance)
    call_in_order(a, b, kernels, shapes, poses, p_AB_W, coarse_aim, now, True)
    rounding = ROUNDING * EPS * (extent + reach)
    distance, error = now[DISTANCE], now[ERROR_BOUND] + 0.5 * reach + rounding
    lower, upper = distance - now[ERROR_BOUND] - reach, distance + now[ERROR_BOUND]
    if now[METHOD] == BOUND_ONLY or lower > far:
        for c in range(PAIR_WIDTH):
            out[c] = now[c]
        out[DISTANCE] = distance - reach if now[METHOD] == BOUND_ONLY else lower
        out[METHOD] = BOUND_ONLY
        return ANSWERED
    plain = PLAIN_DEPTH * aim.size + 4.0 * promised
    if enough > ALL and not has_solid:
        return HIT if upper < enough - plain else UNDECIDED
    if has_solid or error > wanted or not (lower > rounding or upper < -plain):
        return UNDECIDED
    _write_between(now, (reach_a, reach_b), lower, error, out)
    return ANSWERED


@inlined
def hit_or_call(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    aim: Aim,
    enough: float,
    out: Floats,
    scratch: Floats,
) -> bool:
    """Return whether a pair is within ``enough`` [m], or overlaps, for certain; else answer.

    Coarse hulls are tried first: they take a fraction of the time in which a solid is proved to
    overlap. Of a map one cell decides. The answer is written to ``out`` from coarse hulls if these
    suffice, else by the pair's kernel. ``scratch`` is a row.
    """
    verdict, type_a, type_b = UNDECIDED, shapes.types[a], shapes.types[b]
    if may_decide(type_a, type_b, enough, aim.accuracy):
        verdict = by_coarse_hulls(a, b, kernels, shapes, poses, p_AB_W, aim, enough, out)
    elif enough >= 0.0 and is_map(max(type_a, type_b)):
        return overlaps_a_cell(a, b, kernels, shapes, poses, p_AB_W, aim, out)
    if verdict == UNDECIDED:
        if enough >= 0.0 and is_plain_overlap(a, b, kernels, shapes, poses, p_AB_W, scratch):
            return True
        call_in_order(a, b, kernels, shapes, poses, p_AB_W, aim, out, False)
    return verdict == HIT
