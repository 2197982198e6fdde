"""Rescaling to about 1 m of pairs so small or large that products of lengths leave float64.

A power of two changes no digit of a length, and the signed distance scales with the lengths.
"""

import math
from typing import Any

from numba import types

from drake_geom_ros.geometry._proximity.kernels.calling.pairs import (
    DISTANCE,
    ERROR_BOUND,
    PAIR_SIGNATURE,
    WITNESS_A,
    WITNESS_B,
    Aim,
    OrientedShape,
    call_kernel,
    compiled_address,
)
from drake_geom_ros.geometry._proximity.kernels.shapes.hulls import COARSE_HULL
from drake_geom_ros.geometry._proximity.kernels.vectors import norm, vector_at
from drake_geom_ros.geometry._proximity.kinds import CONVEX, ELLIPSOID, VERTEX_COUNT
from drake_geom_ros.geometry._proximity.runtime.addresses import Address, caller
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats
from drake_geom_ros.geometry._proximity.runtime.compiled import allocating, inlined
from drake_geom_ros.geometry._proximity.tolerances import LARGE_SIZE, LEAST_LENGTH, SMALL_SIZE

# Signature of ``at_one_metre`` and other functions that call a kernel: its address comes first.
SIGNATURE_BY_ADDRESS = types.void(types.intp, *PAIR_SIGNATURE.args)
call_by_address = caller(SIGNATURE_BY_ADDRESS)


@inlined
def is_extreme(size: float, p_AB_W: Floats) -> bool:
    """Return whether products of a few lengths of a pair may leave the range of float64.

    ``size`` [m] is that of its shapes, ``p_AB_W`` the position of B from A.
    """
    x, y, z = abs(p_AB_W[0]), abs(p_AB_W[1]), abs(p_AB_W[2])
    return not SMALL_SIZE < size + x + y + z < LARGE_SIZE


@inlined
def vanishes(kind: int, shape: Floats) -> bool:
    """Return whether products of a shape's lengths may leave float64 with any partner.

    Kernels of ellipsoids square the semi-axes.
    """
    return kind == ELLIPSOID and min(shape[0], shape[1], shape[2]) < SMALL_SIZE


@allocating
def resized(kind: int, shape: Floats, exponent: int) -> Floats:
    """Return a copy of a shape's parameters with its lengths times 2^exponent.

    Semi-axes negligible beside 1 m are replaced by a length whose powers stay within float64.
    """
    copy = shape.copy()
    first, last = 0, shape.size
    if kind == CONVEX:
        # After the number of vertices follow their coordinates, the defect and the ball.
        first, last = 1, min(shape.size, 3 * int(shape[VERTEX_COUNT]) + COARSE_HULL)
    for k in range(first, last):
        copy[k] = math.ldexp(copy[k], exponent)
        if kind == ELLIPSOID:
            copy[k] = max(copy[k], LEAST_LENGTH)
    return copy


@allocating
def at_one_metre(
    address: Address,
    A: OrientedShape,
    B: OrientedShape,
    p_AB_W: Floats,
    aim: Aim,
    out: Floats,
) -> None:
    """Call the kernel at an address for the pair rescaled to about 1 m.

    It is itself called by address. Copying a shape may fail, and inlined into the narrow phase
    that possibility made every other pair take 100 ns longer.
    """
    largest = max(aim.size, norm(vector_at(p_AB_W, 0)))
    _, e = math.frexp(largest)
    p = p_AB_W.copy()
    for k in range(3):
        p[k] = math.ldexp(p[k], -e)
    shape_A, shape_B = resized(A.kind, A.shape, -e), resized(B.kind, B.shape, -e)
    A, B = OrientedShape(A.kind, shape_A, A.R_W), OrientedShape(B.kind, shape_B, B.R_W)
    aim = Aim(
        math.ldexp(aim.size, -e),
        math.ldexp(aim.tolerance, -e),
        math.ldexp(aim.cutoff, -e),
        math.ldexp(aim.accuracy, -e),
    )
    call_kernel(address, A, B, p, aim, out)
    for k in (DISTANCE, ERROR_BOUND):
        out[k] = math.ldexp(out[k], e)
    for k in range(3):
        out[WITNESS_A + k] = math.ldexp(out[WITNESS_A + k], e)
        out[WITNESS_B + k] = math.ldexp(out[WITNESS_B + k], e)


def address_at_one_metre() -> Any:
    """Compile ``at_one_metre`` and return its address."""
    return compiled_address(at_one_metre, SIGNATURE_BY_ADDRESS)
