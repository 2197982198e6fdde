"""Calls of the kernels of pairs, by address: the lower type first."""

from __future__ import annotations

import math

from drake_geom_ros.geometry._proximity.kernels.addresses import (
    AT_ONE_METRE,
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
    NORMAL,
    WITNESS_A,
    WITNESS_B,
    Aim,
    OrientedShape,
    call_kernel,
)
from drake_geom_ros.geometry._proximity.kernels.pair_table import TYPE_COUNT
from drake_geom_ros.geometry._proximity.kernels.shapes.maps import is_map
from drake_geom_ros.geometry._proximity.kinds import CONVEX, HALF_SPACE, SOLID
from drake_geom_ros.geometry._proximity.pairs.slots import Shapes
from drake_geom_ros.geometry._proximity.runtime.addresses import Addresses
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import compiled, inlined
from drake_geom_ros.geometry._proximity.runtime.views import part, row


@inlined
def _code(type_a: int, type_b: int) -> int:
    """Return where a pair of types stands in ROW_OF_TYPES."""
    return min(type_a, type_b) * TYPE_COUNT + max(type_a, type_b)


@inlined
def oriented(k: int, shapes: Shapes, R_WGs: Floats) -> OrientedShape:
    """Return shape k as kernels take it."""
    types, starts, pool = shapes
    return OrientedShape(types[k], part(pool, starts[k], starts[k + 1]), row(R_WGs, k))


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
) -> None:
    """Call a pair's kernel, the lower type first; only here an answer is turned around."""
    types, (R_WGs, p_WGs) = shapes.types, poses
    swapped = types[a] > types[b]
    if swapped:
        a, b = b, a
        for c in range(3):
            out[NORMAL + c] = -out[NORMAL + c]
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    address = kernels[ROWS[_code(types[a], types[b])]]
    A, B = oriented(a, shapes, R_WGs), oriented(b, shapes, R_WGs)
    # Solids and maps, the highest types, hold areas and counts too: kernels take them as they are.
    extreme = is_extreme(aim.size, p_AB_W)
    extreme = extreme or vanishes(A.kind, A.shape) or vanishes(B.kind, B.shape)
    if extreme and B.kind <= CONVEX:
        call_by_address(kernels[AT_ONE_METRE], address, A, B, p_AB_W, aim, out)
    elif is_map(B.kind):
        call_by_address(kernels[OVER_MAP], address, A, B, p_AB_W, aim, out)
    else:
        call_kernel(address, A, B, p_AB_W, aim, out)
    if swapped:
        for c in range(3):
            # Measured from the other body's origin from now on.
            p_a = out[WITNESS_A + c] - p_AB_W[c]
            p_b = out[WITNESS_B + c] - p_AB_W[c]
            out[WITNESS_A + c], out[WITNESS_B + c] = p_b, p_a
            out[NORMAL + c] = -out[NORMAL + c]


@inlined
def recall(out: Floats, level_gap: float, type_a: int, type_b: int) -> None:
    """Forget the normal from which a kernel would start, where it is not this level's.

    So what one level was asked changes no digit of what another answers. With solids and maps a
    kernel starts from nothing: which leaves are looked at would depend on it.
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
    """Tell whether a bounded body a and a solid b are seen to overlap."""
    R_WGs, p_WGs = poses
    for c in range(3):
        p_AB_W[c] = p_WGs[b, c] - p_WGs[a, c]
    A, B = oriented(a, shapes, R_WGs), oriented(b, shapes, R_WGs)
    call_kernel(kernels[PLAIN_OVERLAP], A, B, p_AB_W, Aim(0.0, 0.0, 0.0), out)
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
    """Tell whether a pair with a solid is seen to overlap.

    Its kernel says so, too, and how deep it is. Nothing of this is kept: what is asked next finds
    what it would have found.
    """
    type_a, type_b = shapes.types[a], shapes.types[b]
    if max(type_a, type_b) != SOLID or type_a == HALF_SPACE or type_b == HALF_SPACE:
        return False
    if type_a > type_b:
        a, b = b, a
    return _has_plain_overlap(a, b, kernels, shapes, poses, p_AB_W, out)
