"""Boxes side by side in memory, compared with one box at a time: a prefilter of broad phases.

Their sides (6, n), the lower ones first, are of single precision and rounded outwards: so twice as
many are compared at once, and nobody who is near is missed. Who of those that are found shares a
point, double precision tells. LLVM makes no such comparison of a loop in Python, which ends in a
branch that is guessed wrong as often as not for each box.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    SINGLE_EPS,
    SINGLE_LARGEST,
    SINGLE_TINY,
)

LANES = 8  # boxes that are compared at once; so many more have room behind the last


def empty_sides(count: int) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Return room for the sides of some boxes."""
    return np.zeros((6, count + LANES), dtype=np.float32)


@inlined
def below(value):  # type: ignore[no-untyped-def]
    """Return a number of single precision that is no larger."""
    value = min(value, SINGLE_LARGEST)
    lower = value - SINGLE_EPS * abs(value) - SINGLE_TINY
    return np.float32(lower if lower > -2.0 * SINGLE_LARGEST else -math.inf)


@inlined
def above(value):  # type: ignore[no-untyped-def]
    """Return a number of single precision that is no smaller."""
    return -below(-value)


@inlined
def box_at(sides, k):  # type: ignore[no-untyped-def]
    """Return the six sides of a box, as ``overlapping`` takes them."""
    return sides[0, k], sides[1, k], sides[2, k], sides[3, k], sides[4, k], sides[5, k]


@inlined
def first_lanes(count):  # type: ignore[no-untyped-def]
    """Return the bits of so many boxes, or of all LANES."""
    return (1 << min(count, LANES)) - 1


if config.DISABLE_JIT:

    def overlapping(sides: Any, first: int, box: Any) -> int:
        """Return bits: which of the LANES boxes from the first on overlap a box of six sides."""
        lanes = sides[:, first : first + LANES].T
        meet = (lanes[:, :3] <= box[3:]) & (np.array(box[:3]) <= lanes[:, 3:])
        return sum(1 << k for k, meets in enumerate(meet.all(axis=1)) if meets)

    def lowest(bits: int) -> int:
        """Return the number of the lowest bit that is set."""
        return int(math.log2(bits & -bits))

else:
    from llvmlite import ir

    _SINGLES = ir.VectorType(ir.FloatType(), LANES)
    _UNDEFINED = ir.Constant(_SINGLES, ir.Undefined)
    _PLACES = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)

    @inlined
    def overlapping(sides, first, box):  # type: ignore[no-untyped-def]
        """Return bits: which of the LANES boxes from the first on overlap a box of six sides."""
        return _overlapping(sides.ctypes.data + first * sides.itemsize, sides.strides[0], box)

    @intrinsic
    def _overlapping(typingctx, address, step, box):  # type: ignore[no-untyped-def]
        """Do what ``overlapping`` does; the lower sides are at an address, the next a step on."""

        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            begin, step, given = values

            def load(side):  # type: ignore[no-untyped-def]
                address = builder.add(begin, builder.mul(step, ir.Constant(step.type, side)))
                loaded = builder.load(builder.inttoptr(address, _SINGLES.as_pointer()))
                loaded.align = 4
                return loaded

            def spread(side):  # type: ignore[no-untyped-def]
                number = builder.extract_value(given, side)
                one = builder.insert_element(_UNDEFINED, number, ir.Constant(ir.IntType(32), 0))
                return builder.shuffle_vector(one, one, _PLACES)

            meets = None
            for axis in range(3):
                for low, high in (
                    (load(axis), spread(3 + axis)),  # type: ignore[no-untyped-call]
                    (spread(axis), load(3 + axis)),  # type: ignore[no-untyped-call]
                ):
                    compared = builder.fcmp_ordered('<=', low, high)
                    meets = compared if meets is None else builder.and_(meets, compared)
            bits = builder.bitcast(meets, ir.IntType(LANES))
            return builder.zext(bits, ir.IntType(64))

        return types.int64(types.intp, types.intp, types.UniTuple(types.float32, 6)), codegen

    @intrinsic
    def lowest(typingctx, bits):  # type: ignore[no-untyped-def]
        """Return the number of the lowest bit that is set."""

        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            return builder.cttz(values[0], ir.Constant(ir.IntType(1), 1))

        return types.int64(types.int64), codegen
