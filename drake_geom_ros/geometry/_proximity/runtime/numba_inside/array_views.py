"""Views of arrays as intrinsics, generated inline and without references.

With functions that return ``carray``, compiling everything took 26 % longer. ``views`` and
``handles`` document each view and have fallbacks for other versions of Numba.

Assumption: the structure of an array is that of ``make_array``.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array
from numba.np.numpy_support import from_dtype


def _array_at(context: Any, builder: Any, kind: Any, data: Any, shape: Any) -> Any:
    """Return a C-contiguous array of ``kind`` that begins at ``data``, in generated code.

    ``shape`` are integers, or constants, of generated code; no reference is held.
    """
    itemsize = context.get_constant(types.intp, context.get_abi_sizeof(data.type.pointee))
    strides: list[Any] = []
    step = itemsize
    for extent in reversed(shape):
        strides.insert(0, step)
        step = builder.mul(step, extent)
    array = make_array(kind)(context, builder)
    populate_array(array, data, shape, strides, itemsize, None)
    return array._getvalue()


def taker(record: Any, fields: Any) -> Any:
    """Return the intrinsic that makes a record of arrays from its handle; see ``handles``.

    Making each field with ``carray`` took a twentieth of all compiling, for a hundred arrays.
    """
    kinds = [
        types.Array(from_dtype(np.dtype(number)), 1 + len(extents), 'C')
        for _, number, extents in fields
    ]
    made = types.NamedTuple(kinds, record)

    @intrinsic
    def take(typingctx, handle):  # type: ignore[no-untyped-def]
        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            numbers = make_array(handle)(context, builder, values[0]).data
            place = itertools.count()

            def next_number() -> Any:
                at = builder.gep(numbers, [context.get_constant(types.intp, next(place))])
                return builder.load(at)

            arrays = []
            for kind, (_, _, extents) in zip(kinds, fields, strict=True):
                data = builder.inttoptr(
                    next_number(), context.get_data_type(kind.dtype).as_pointer()
                )
                shape = [
                    next_number() if extent is None else context.get_constant(types.intp, extent)
                    for extent in (None, *extents)
                ]
                arrays.append(_array_at(context, builder, kind, data, shape))
            return context.make_tuple(builder, made, arrays)

        return made(handle), codegen

    return take


def _as_integers(array: Any, number: Any) -> Any:
    """Return the signature and code of a view of 64-bit numbers as integers of a type."""
    kind = types.Array(number, 1, 'C')

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole_value, first = values
        whole = make_array(array)(context, builder, whole_value)
        (size,) = cgutils.unpack_tuple(builder, whole.shape, 1)
        data = builder.gep(whole.data, [first])
        data = builder.bitcast(data, context.get_data_type(number).as_pointer())
        count = builder.mul(builder.sub(size, first), size.type(64 // number.bitwidth))
        return _array_at(context, builder, kind, data, [count])

    return kind(array, types.intp), codegen


@intrinsic
def row(typingctx: Any, array: Any, k: Any) -> Any:
    """Return array[k] of a C-contiguous array of two or three dimensions."""
    kind = types.Array(array.dtype, array.ndim - 1, 'C')

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole_value, number = values
        whole = make_array(array)(context, builder, whole_value)
        shape = cgutils.unpack_tuple(builder, whole.shape, array.ndim)
        stride, *_ = cgutils.unpack_tuple(builder, whole.strides)
        offset = builder.mul(number, stride)
        data = cgutils.pointer_add(builder, whole.data, offset, whole.data.type)
        return _array_at(context, builder, kind, data, shape[1:])

    return kind(array, types.intp), codegen


@intrinsic
def part(typingctx: Any, array: Any, start: Any, stop: Any) -> Any:
    """Return array[start:stop] of a contiguous array, 0 <= start <= stop <= its size."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole_value, first, end = values
        whole = make_array(array)(context, builder, whole_value)
        data = builder.gep(whole.data, [first])
        return _array_at(context, builder, array, data, [builder.sub(end, first)])

    return array(array, types.intp, types.intp), codegen


@intrinsic
def table(typingctx: Any, array: Any, start: Any, rows: Any, columns: Any) -> Any:
    """Return the elements of a contiguous array from ``start`` on as a table (rows, columns)."""
    kind = types.Array(array.dtype, 2, 'C')

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        whole_value, first, *shape = values
        whole = make_array(array)(context, builder, whole_value)
        return _array_at(context, builder, kind, builder.gep(whole.data, [first]), shape)

    return kind(array, types.intp, types.intp, types.intp), codegen


@intrinsic
def integers(typingctx: Any, array: Any, start: Any) -> Any:
    """Return a view of an array of 64-bit numbers from ``start`` on as 32-bit integers."""
    return _as_integers(array, types.int32)


@intrinsic
def wide_integers(typingctx: Any, array: Any, start: Any) -> Any:
    """Return a view of an array of 64-bit numbers from ``start`` on as 64-bit integers."""
    return _as_integers(array, types.int64)


@intrinsic
def outlive(typingctx: Any, array: Any) -> Any:
    """Keep an array alive up to this call, because views of it hold no reference."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return context.get_dummy_value()

    return types.none(array), codegen
