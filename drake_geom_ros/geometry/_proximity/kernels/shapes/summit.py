"""Index of the point farthest along a direction, by SIMD with eight lanes.

LLVM vectorises the search for a largest number, but not for its index, which took a second pass
over all points. Here the code is written with vectors of eight numbers (LLVM Language Reference,
*Vector Type*), which LLVM maps to the registers of the processor: each lane has the farthest of
its points, and finally the lanes are compared. For 64 points that takes a third of the time of two
passes.
"""

from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from drake_geom_ros.geometry._proximity.runtime.compiled import inlined

LANES = 8
_INTEGER, _NUMBER = ir.IntType(64), ir.DoubleType()
_INTEGERS, _NUMBERS = ir.VectorType(_INTEGER, LANES), ir.VectorType(_NUMBER, LANES)


def _farthest_index(numbers: Any, n: int, x: float, y: float, z: float) -> int:
    """Return the first of n points, 1 to n, farthest along (x, y, z).

    ``numbers`` are one unused number, and the n x, n y and n z of at least LANES points.
    """
    best, value = 1, numbers[1] * x + numbers[1 + n] * y + numbers[1 + 2 * n] * z
    for k in range(2, n + 1):
        along = numbers[k] * x + numbers[k + n] * y + numbers[k + 2 * n] * z
        if along > value:
            best, value = k, along
    return best


def _same(builder: Any, value: Any, kind: Any) -> Any:
    """Return a vector of a type with the value in each lane."""
    lane = ir.IntType(32)
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), value, lane(0))
    zeros = ir.Constant(ir.VectorType(lane, LANES), [0] * LANES)
    return builder.shuffle_vector(one, ir.Constant(kind, ir.Undefined), zeros)


def _along(builder: Any, data: Any, place: Any, n: Any, direction: Any) -> Any:
    """Return the offsets along a direction of the eight points from an index on."""
    terms = []
    for axis in direction:
        pointer = builder.bitcast(builder.gep(data, [place]), _NUMBERS.as_pointer())
        loaded = builder.load(pointer)
        loaded.align = 8
        terms.append(builder.fmul(loaded, axis))
        place = builder.add(place, n)
    return builder.fadd(builder.fadd(terms[0], terms[1]), terms[2])


def _halves(builder: Any, value: Any, width: int) -> tuple[Any, Any]:
    """Return the lower and the upper ``width`` lanes of a vector of twice as many."""
    lane = ir.IntType(32)
    if width == 1:
        return builder.extract_element(value, lane(0)), builder.extract_element(value, lane(1))
    none, kind = ir.Constant(value.type, ir.Undefined), ir.VectorType(lane, width)
    lower = builder.shuffle_vector(value, none, ir.Constant(kind, list(range(width))))
    upper = ir.Constant(kind, list(range(width, 2 * width)))
    return lower, builder.shuffle_vector(value, none, upper)


def _first_of_lanes(builder: Any, value: Any, place: Any) -> Any:
    """Return the least index among the lanes of the largest value.

    By halves, because LLVM 20 miscompiled rotated vectors and compared a lane with itself.
    """
    width = LANES
    while width > 1:
        width //= 2
        value, v = _halves(builder, value, width)
        place, p = _halves(builder, place, width)
        level = builder.and_(
            builder.fcmp_ordered('==', v, value), builder.icmp_signed('<', p, place)
        )
        better = builder.or_(builder.fcmp_ordered('>', v, value), level)
        value, place = builder.select(better, v, value), builder.select(better, p, place)
    return place


@intrinsic
def _at(typing: Any, address: Any, n: Any, x: Any, y: Any, z: Any) -> Any:
    """Return the signature of ``farthest_index`` for an address, and its code generator."""

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        start, count, *direction = arguments
        data = builder.inttoptr(start, _NUMBER.as_pointer())
        direction = [_same(builder, value, _NUMBERS) for value in direction]
        one, last = _INTEGER(1), builder.sub(count, _INTEGER(LANES - 1))
        value = cgutils.alloca_once_value(builder, _along(builder, data, one, count, direction))
        place = cgutils.alloca_once_value(builder, _same(builder, one, _INTEGERS))
        blocks = builder.udiv(builder.add(count, _INTEGER(LANES - 1)), _INTEGER(LANES))
        with cgutils.for_range(builder, blocks, start=one) as loop:
            first = builder.add(builder.mul(loop.index, _INTEGER(LANES)), one)
            # The last eight are compared together, some of them for the second time.
            first = builder.select(builder.icmp_signed('<', first, last), first, last)
            along = _along(builder, data, first, count, direction)
            before = builder.load(value)
            farther = builder.fcmp_ordered('>', along, before)
            builder.store(builder.select(farther, along, before), value)
            here = builder.select(farther, _same(builder, first, _INTEGERS), builder.load(place))
            builder.store(here, place)
        lanes = ir.Constant(_INTEGERS, list(range(LANES)))
        places = builder.add(builder.load(place), lanes)
        return _first_of_lanes(builder, builder.load(value), places)

    return types.int64(types.intp, types.int64, *3 * (types.float64,)), write


@inlined
def _compiled_farthest_index(numbers: Any, n: int, x: float, y: float, z: float) -> int:
    """Return the index that ``_farthest_index`` does, from compiled code."""
    return _at(numbers.ctypes.data, n, x, y, z)


farthest_index = _farthest_index if config.DISABLE_JIT else _compiled_farthest_index
