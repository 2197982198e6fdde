"""Distances of a point from eight boxes or triangles side by side, all at once.

The distances serve to choose by, they are never an answer: those of triangles are off by at most
``LANE_ERROR`` times the distance of their farthest corner, and those of needles may be too small
by their width.

LLVM does not vectorize a Python loop as long as this, so the formulas are written once, over
*lanes*: LANES numbers that are added, multiplied and compared together. Compiled they are vectors
of LLVM, uncompiled arrays of NumPy.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import inlined
from drake_geom_ros.geometry._proximity.tolerances import NEEDLE, SMALL_SQUARE

LANES = 8
BOX_LANES = 6 * LANES  # numbers: lower corners, then upper ones, each coordinate by itself
TRIANGLE_LANES = 9 * LANES  # numbers: first, second, third corners, each coordinate by itself
WIDER = 1.001  # for rounding

Lanes = Any  # LANES numbers


def _dot(a: Any, b: Any) -> Lanes:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Any, b: Any) -> tuple[Lanes, Lanes, Lanes]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _sub(a: Any, b: Any) -> tuple[Lanes, ...]:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _gaps_of_boxes(sides: list[Lanes], q: list[Lanes]) -> Lanes:
    """Return how far q is from boxes of six sides; 0 within."""
    gaps = [_most(_most(sides[k] - q[k], q[k] - sides[3 + k]), 0.0) for k in range(3)]
    return _root(_dot(gaps, gaps))


def _gaps_of_triangles(corners: list[Lanes], q: list[Lanes]) -> tuple[Lanes, Lanes]:
    """Return (lower, upper) bounds of the distances of q from triangles of nine coordinates.

    Where the foot of the perpendicular is inside all three edges it is as far as the plane, else
    as the nearest edge. A needle has no normal that is good enough: wherever the foot is, it is no
    farther from an edge than the needle is wide.
    """
    a, b, c = (_sub(corners[3 * k : 3 * k + 3], q) for k in range(3))
    edges = (a, _sub(b, a)), (b, _sub(c, b)), (c, _sub(a, c))
    normal = _cross(edges[0][1], edges[1][1])
    area = _dot(normal, normal)
    nearest: Lanes = None
    within: Lanes = None
    longest: Lanes = None
    for at, along in edges:
        length = _dot(along, along)
        share = _least(_most(-(_dot(at, along) / length), 0.0), 1.0)
        v = tuple(x + y * share for x, y in zip(at, along, strict=True))
        inside, away = -_dot(_cross(normal, along), at), _dot(v, v)
        nearest = away if nearest is None else _least(away, nearest)
        within = inside if within is None else _least(inside, within)
        longest = length if longest is None else _most(length, longest)
    height, to_edge = _dot(normal, a), _root(nearest)
    sound = _where(within < 0.0, to_edge, _root(height * height / area))
    width = _root(_where(area < SMALL_SQUARE, longest, area / longest)) * WIDER
    is_sound = _most(longest * longest * NEEDLE, SMALL_SQUARE) < area
    least = _where(is_sound, sound, _most(to_edge - width, 0.0))
    most = _where(is_sound, sound, to_edge)
    return least, _where(most < math.inf, most, math.inf)


if config.DISABLE_JIT:

    def _where(condition: Any, first: Any, second: Any) -> Any:
        return np.where(condition, first, second)

    def _least(first: Any, second: Any) -> Any:
        return np.minimum(first, second)

    def _most(first: Any, second: Any) -> Any:
        return np.maximum(first, second)

    def _root(lanes: Any) -> Any:
        return np.sqrt(lanes)

    def _within(gaps: Any, limit: float) -> int:
        """Return the bits of the gaps that are not beyond the limit."""
        return sum(1 << k for k in range(LANES) if not gaps[k] > limit)

    def near_boxes(
        shape: Floats, at: int, q: Vector, limit: float, gaps: Floats
    ) -> tuple[int, int]:
        """Do what the compiled ``near_boxes`` does."""
        with np.errstate(all='ignore'):
            gaps[:] = _gaps_of_boxes(list(shape[at : at + BOX_LANES].reshape(6, LANES)), list(q))
        return _within(gaps, limit), int(np.argmin(gaps))

    def near_triangles(shape: Floats, at: int, q: Vector, limit: float, loose: float) -> int:
        """Do what the compiled ``near_triangles`` does."""
        corners = list(shape[at : at + TRIANGLE_LANES].reshape(9, LANES))
        with np.errstate(all='ignore'):
            least, most = _gaps_of_triangles(corners, list(q))
        return _within(least, min(limit, most.min()) + loose)

    def lowest(bits: int) -> int:
        """Return the number of the lowest bit that is set."""
        return int(math.log2(bits & -bits))

else:
    from llvmlite import ir

    _DOUBLES, _LONG = ir.VectorType(ir.DoubleType(), LANES), ir.IntType(64)
    _UNDEFINED = ir.Constant(_DOUBLES, ir.Undefined)
    _PLACES = ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES)
    _SQUARE_ROOT = f'llvm.sqrt.v{LANES}f64'

    class _Vector:
        """Lanes as a vector of LLVM; a number that is combined with it is so in each lane."""

        def __init__(self, builder: Any, value: Any) -> None:
            self.builder, self.value = builder, value

        def of(self, other: Any) -> Any:
            """Return the vector of other lanes, or of a number in each."""
            if isinstance(other, _Vector):
                return other.value
            return ir.Constant(_DOUBLES, [float(other)] * LANES)

        def __add__(self, other: Any) -> _Vector:
            return _Vector(self.builder, self.builder.fadd(self.value, self.of(other)))

        def __sub__(self, other: Any) -> _Vector:
            return _Vector(self.builder, self.builder.fsub(self.value, self.of(other)))

        def __mul__(self, other: Any) -> _Vector:
            return _Vector(self.builder, self.builder.fmul(self.value, self.of(other)))

        def __truediv__(self, other: Any) -> _Vector:
            return _Vector(self.builder, self.builder.fdiv(self.value, self.of(other)))

        def __neg__(self) -> _Vector:
            return _Vector(self.builder, self.builder.fneg(self.value))

        def __lt__(self, other: Any) -> Any:
            return self.builder.fcmp_ordered('<', self.value, self.of(other))

    def _where(condition: Any, first: Any, second: Any) -> Any:
        chosen = first.builder.select(condition, first.value, first.of(second))
        return _Vector(first.builder, chosen)

    def _least(first: Any, second: Any) -> Any:
        return _where(first < second, first, second)

    def _most(first: Any, second: Any) -> Any:
        chosen = first.builder.select(first < second, first.of(second), first.value)
        return _Vector(first.builder, chosen)

    def _root(lanes: Any) -> Any:
        module = lanes.builder.module
        function = module.globals.get(_SQUARE_ROOT)
        if function is None:
            signature = ir.FunctionType(_DOUBLES, [_DOUBLES])
            function = ir.Function(module, signature, _SQUARE_ROOT)
        return _Vector(lanes.builder, lanes.builder.call(function, [lanes.value]))

    def _spread(builder: Any, number: Any) -> Any:
        """Return a vector with a number in each lane."""
        one = builder.insert_element(_UNDEFINED, number, ir.Constant(ir.IntType(32), 0))
        return builder.shuffle_vector(one, one, _PLACES)

    def _arguments(builder: Any, begin: Any, count: int, q: Any) -> Any:
        """Return ``count`` lanes from an address on, and the coordinates of q in each."""
        address, numbers = builder.inttoptr(begin, _DOUBLES.as_pointer()), []
        for k in range(count):
            loaded = builder.load(builder.gep(address, [ir.Constant(_LONG, k)]))
            loaded.align = 8
            numbers.append(_Vector(builder, loaded))
        spread = (_spread(builder, builder.extract_value(q, k)) for k in range(3))
        return numbers, [_Vector(builder, each) for each in spread]

    def _least_of(lanes: Any) -> Any:
        """Return the least of all lanes, in each."""
        for step in (1, 2, 4):
            places = ir.Constant(_PLACES.type, [k ^ step for k in range(LANES)])
            turned = lanes.builder.shuffle_vector(lanes.value, lanes.value, places)
            lanes = _least(lanes, _Vector(lanes.builder, turned))
        return lanes

    def _bits(builder: Any, chosen: Any) -> Any:
        return builder.zext(builder.bitcast(chosen, ir.IntType(LANES)), _LONG)

    _POINT = types.UniTuple(types.float64, 3)

    @intrinsic
    def _near_boxes(typingctx: Any, address: Any, q: Any, limit: Any, gaps: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            begin, q, limit, to = values
            gaps = _gaps_of_boxes(*_arguments(builder, begin, 6, q))
            stored = builder.store(gaps.value, builder.inttoptr(to, _DOUBLES.as_pointer()))
            stored.align = 8
            near = builder.fcmp_unordered('<=', gaps.value, _spread(builder, limit))
            first = builder.fcmp_ordered('==', gaps.value, _least_of(gaps).value)
            both = builder.shl(_bits(builder, first), ir.Constant(_LONG, LANES))
            return builder.or_(_bits(builder, near), both)

        return types.int64(types.intp, _POINT, types.float64, types.intp), codegen

    @intrinsic
    def _near_triangles(typingctx: Any, address: Any, q: Any, limit: Any, loose: Any) -> Any:
        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            begin, q, limit, loose = values
            least, most = _gaps_of_triangles(*_arguments(builder, begin, 9, q))
            bound = _least(_least_of(most), _Vector(builder, _spread(builder, limit)))
            reach = bound + _Vector(builder, _spread(builder, loose))
            return _bits(builder, builder.fcmp_unordered('<=', least.value, reach.value))

        return types.int64(types.intp, _POINT, types.float64, types.float64), codegen

    @intrinsic
    def lowest(typingctx: Any, bits: Any) -> Any:
        """Return the number of the lowest bit that is set."""

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            return builder.cttz(values[0], ir.Constant(ir.IntType(1), 1))

        return types.int64(types.int64), codegen

    @inlined
    def near_boxes(
        shape: Floats, at: int, q: Vector, limit: float, gaps: Floats
    ) -> tuple[int, int]:
        """Fill the gaps (LANES,) [m] between q and the boxes that begin at ``at``.

        Returns (bits, lane): those not known to be beyond the limit, and the nearest.
        """
        bits = _near_boxes(shape.ctypes.data + 8 * at, q, limit, gaps.ctypes.data)
        return bits & ((1 << LANES) - 1), lowest(bits >> LANES | 1 << (LANES - 1))

    @inlined
    def near_triangles(shape: Floats, at: int, q: Vector, limit: float, loose: float) -> int:
        """Return the bits of those triangles that begin at ``at`` which may be the nearest to q.

        They are not farther, by more than ``loose``, than the limit, nor than another's upper
        bound.
        """
        return _near_triangles(shape.ctypes.data + 8 * at, q, limit, loose)
