"""SIMD comparison of one box with many, a prefilter of the broad phases.

The sides (6, n) of the boxes, lower ones first, are in single precision and rounded outwards. So
twice as many are compared at once, and no overlap is missed; double precision then decides about
the boxes that pass. LLVM does not vectorise such a comparison in a Python loop, whose branch for
each box is mispredicted half of the time.
"""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from drake_geom_ros.geometry._proximity.runtime.arrays import Singles, single
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import (
    SINGLE_EPS,
    SINGLE_LARGEST,
    SINGLE_TINY,
)

Sides: TypeAlias = tuple[float, float, float, float, float, float]  # of a box, lower ones first

LANES = 8  # boxes compared at once; arrays have as many spare places behind the last box


def empty_sides(count: int) -> Singles:
    """Return an array for the sides of ``count`` boxes."""
    return np.zeros((6, count + LANES), dtype=np.float32)


@inlined
def below(value: float) -> float:
    """Return a single-precision number that is no larger than ``value``."""
    value = min(value, SINGLE_LARGEST)
    lower = value - SINGLE_EPS * abs(value) - SINGLE_TINY
    return single(lower if lower > -2.0 * SINGLE_LARGEST else -math.inf)


@inlined
def above(value: float) -> float:
    """Return a single-precision number that is no smaller than ``value``."""
    return -below(-value)


@inlined
def box_at(sides: Singles, k: int) -> tuple[float, float, float, float, float, float]:
    """Return the six sides of a box, as ``overlapping`` takes them."""
    return sides[0, k], sides[1, k], sides[2, k], sides[3, k], sides[4, k], sides[5, k]


@inlined
def first_lanes(count: int) -> int:
    """Return a mask of the first ``count`` lanes, at most LANES."""
    return (1 << min(count, LANES)) - 1


if config.DISABLE_JIT:

    def overlapping(sides: Singles, first: int, box: Sides) -> int:
        """Return a bit mask of the LANES boxes from ``first`` on that overlap a box."""
        lanes = sides[:, first : first + LANES].T
        meet = (lanes[:, :3] <= box[3:]) & (np.array(box[:3]) <= lanes[:, 3:])
        return sum(1 << k for k in range(len(meet)) if meet[k].all())

    def lowest(bits: int) -> int:
        """Return the number of the lowest bit that is set."""
        return int(math.log2(bits & -bits))

else:
    from llvmlite import ir

    _SINGLES = ir.VectorType(ir.FloatType(), LANES)
    _UNDEFINED = ir.Constant(_SINGLES, ir.Undefined)
    _PLACES = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)

    @inlined
    def overlapping(sides: Singles, first: int, box: Sides) -> int:
        """Return a bit mask of the LANES boxes from ``first`` on that overlap a box."""
        return _overlapping(sides.ctypes.data + first * sides.itemsize, sides.strides[0], box)

    @intrinsic
    def _overlapping(typingctx: Any, address: Any, step: Any, box: Any) -> Any:
        """Implement ``overlapping``: rows of sides begin at an address, ``step`` bytes apart."""

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            begin, step, sides = values

            def load(side: Any) -> Any:
                address = builder.add(begin, builder.mul(step, ir.Constant(step.type, side)))
                loaded = builder.load(builder.inttoptr(address, _SINGLES.as_pointer()))
                loaded.align = 4
                return loaded

            def spread(side: Any) -> Any:
                number = builder.extract_value(sides, side)
                one = builder.insert_element(_UNDEFINED, number, ir.Constant(ir.IntType(32), 0))
                return builder.shuffle_vector(one, one, _PLACES)

            meets = None
            for axis in range(3):
                for low, high in (
                    (load(axis), spread(3 + axis)),
                    (spread(axis), load(3 + axis)),
                ):
                    compared = builder.fcmp_ordered('<=', low, high)
                    meets = compared if meets is None else builder.and_(meets, compared)
            bits = builder.bitcast(meets, ir.IntType(LANES))
            return builder.zext(bits, ir.IntType(64))

        return types.int64(types.intp, types.intp, types.UniTuple(types.float32, 6)), codegen

    @intrinsic
    def lowest(typingctx: Any, bits: Any) -> Any:
        """Return the number of the lowest bit that is set."""

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.cttz(values[0], ir.Constant(ir.IntType(1), 1))

        return types.int64(types.int64), codegen
