"""Calls of pair kernels by address, with the lower shape type first."""

from __future__ import annotations

import math

import numpy as np

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    AT_ONE_METRE,
    HULLS,
    OVER_MAP,
    PLAIN_OVERLAP,
    ROWS,
)
from drake_geom_ros.geometry._proximity.kernels.calling.extremes import (
    call_by_address,
    is_extreme,
    vanishes,
)
from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    LEVEL_GAP,
    METHOD,
    NORMAL,
    PAIR_WIDTH,
    WITNESS_A,
    WITNESS_B,
    Aim,
    OrientedShape,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import TYPE_COUNT
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import (
    coarse_hull_at,
    end_of_header,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE, OPEN, SOLID
from drake_geom_ros.geometry._proximity.pairs.slots import Shapes
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Indices
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row
from drake_geom_ros.geometry._proximity.tolerances import TOUCHING_DEPTH


@inlined
def _code(type_a: int, type_b: int) -> int:
    """Return the index of a pair of types in ``ROWS``."""
    return min(type_a, type_b) * TYPE_COUNT + max(type_a, type_b)


@inlined
def oriented(k: int, shapes: Shapes, R_WGs: Floats) -> OrientedShape:
    """Return shape k as the ``OrientedShape`` that kernels take."""
    types, starts, pool = shapes
    return OrientedShape(types[k], part(pool, starts[k], starts[k + 1]), row(R_WGs, k))


@inlined
def coarse(k: int, shapes: Shapes, R_WGs: Floats) -> OrientedShape:
    """Return the coarse hull of shape k, or the shape itself; of a solid without one, its hull."""
    kind, start, end = shapes.types[k], shapes.starts[k], shapes.starts[k + 1]
    shape = part(shapes.pool, start, end)
    if kind >= CONVEX:
        at = coarse_hull_at(shape)
        first = at + 1 if at > 0 else 0
        if at > 0 or kind == SOLID:
            shape = part(shapes.pool, start + first, start + end_of_header(shape, first))
        kind = CONVEX
    return OrientedShape(kind, shape, row(R_WGs, k))


@inlined
def _in_order(
    a: int, b: int, types: Indices, p_WGs: Floats, p_AB_W: Floats, out: Floats
) -> tuple[int, int, bool]:
    """Return a pair with the lower type first, and whether that swapped it.

    ``p_AB_W`` and the normal in ``out``, a hint, are written in that order.
    """
    swapped = types[a] > types[b]
    if swapped:
        a, b = b, a
        for c in range(3):
            out[NORMAL + c] = -out[NORMAL + c]
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    return a, b, swapped


@inlined
def _swap_sides(p_AB_W: Floats, out: Floats) -> None:
    """Make an answer about (A, B) one about (B, A)."""
    for c in range(3):
        # Measured from the origin of the other body, which is now A.
        p_a = out[WITNESS_A + c] - p_AB_W[c]
        p_b = out[WITNESS_B + c] - p_AB_W[c]
        out[WITNESS_A + c], out[WITNESS_B + c] = p_b, p_a
        out[NORMAL + c] = -out[NORMAL + c]


@inlined
def call_in_order(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    aim: Aim,
    out: Floats,
    is_coarse: bool,
) -> None:
    """Call a pair's kernel with the lower type first, and swap the answer back if needed.

    If ``is_coarse``, the kernel is that of their coarse hulls, of which none may be extreme.
    """
    types, (R_WGs, p_WGs) = shapes.types, poses
    a, b, swapped = _in_order(a, b, types, p_WGs, p_AB_W, out)
    address = kernels[ROWS[_code(types[a], types[b])]]
    if is_coarse:
        if types[b] == SOLID:
            address = kernels[HULLS]
        A, B = coarse(a, shapes, R_WGs), coarse(b, shapes, R_WGs)
        call_kernel(address, A, B, p_AB_W, aim, out)
    else:
        A, B = oriented(a, shapes, R_WGs), oriented(b, shapes, R_WGs)
        # Solids and maps, the highest types, also have areas and counts as parameters: no
        # rescaling.
        extreme = is_extreme(aim.size, p_AB_W)
        extreme = extreme or vanishes(A.kind, A.shape) or vanishes(B.kind, B.shape)
        if extreme and B.kind <= CONVEX:
            call_by_address(kernels[AT_ONE_METRE], address, A, B, p_AB_W, aim, out)
        elif is_map(B.kind):
            call_by_address(kernels[OVER_MAP], address, A, B, p_AB_W, aim, out)
        else:
            call_kernel(address, A, B, p_AB_W, aim, out)
    if swapped:
        _swap_sides(p_AB_W, out)


@inlined
def recall(out: Floats, level_gap: float, type_a: int, type_b: int) -> None:
    """Clear a kernel's hint unless it comes from the same level.

    So a query at one level changes no digit of the answers at another. Kernels of solids and maps
    get no hint at all, because the leaves that they visit would depend on it.
    """
    if max(type_a, type_b) >= SOLID or (
        out[LEVEL_GAP] != level_gap and out[LEVEL_GAP] > -math.inf
    ):
        for c in range(3):
            out[NORMAL + c] = 0.0


@compiled
def _has_plain_overlap(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    out: Floats,
) -> bool:
    """Return whether a bounded body a and a solid b plainly overlap."""
    R_WGs, p_WGs = poses
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    A, B = oriented(a, shapes, R_WGs), oriented(b, shapes, R_WGs)
    call_kernel(kernels[PLAIN_OVERLAP], A, B, p_AB_W, Aim(0.0, 0.0, 0.0, 0.0), out)
    return out[DISTANCE] < 0.0


@inlined
def is_plain_overlap(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    out: Floats,
) -> bool:
    """Return whether a pair with a solid plainly overlaps.

    The pair's kernel would also compute the depth. Nothing of this test is stored, so later
    queries return the same answers as without it.
    """
    type_a, type_b = shapes.types[a], shapes.types[b]
    if max(type_a, type_b) != SOLID or type_a == HALF_SPACE or type_b == HALF_SPACE:
        return False
    if type_a > type_b:
        a, b = b, a
    return _has_plain_overlap(a, b, kernels, shapes, poses, p_AB_W, out)


@allocating
def overlaps_a_cell(
    a: int,
    b: int,
    kernels: Addresses,
    shapes: Shapes,
    poses: tuple[Floats, Floats],
    p_AB_W: Floats,
    aim: Aim,
    out: Floats,
) -> bool:
    """Return whether a pair with a map plainly overlaps; else answer in ``out``.

    The depth of a union of cells takes longer than all else, and nothing of it is wanted here.
    """
    now = np.zeros(PAIR_WIDTH)
    any_depth = Aim(aim.size, aim.tolerance, aim.cutoff, math.inf)
    call_in_order(a, b, kernels, shapes, poses, p_AB_W, any_depth, now, False)
    if now[METHOD] == OPEN and now[DISTANCE] < -2.0 * TOUCHING_DEPTH * aim.size:
        return True
    for c in range(PAIR_WIDTH):
        out[c] = now[c]
    return False
