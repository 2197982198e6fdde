"""Views of arrays that hold no reference: for loops in which every pair has its shapes and poses.

A slice in compiled code keeps its array alive by a count of references. Where Numba cannot prove
that the count is not needed, each slice of each pair costs two atomic operations and a call: half
of the narrow phase of 1000 balls. These views do without; the array that they show must outlive
them, as arguments of the loop do, and arrays of one's own that ``outlive`` is called with at last.
"""

from typing import Any

import numpy as np
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array, populate_array


def array_at(context: Any, builder: Any, kind: Any, data: Any, shape: Any) -> Any:
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


if config.DISABLE_JIT:

    def row(array: Any, k: int) -> Any:
        """Return array[k]."""
        return array[k]

    def part(array: Any, start: int, stop: int) -> Any:
        """Return array[start:stop]."""
        return array[start:stop]

    def table(array: Any, start: int, rows: int, columns: int) -> Any:
        """Return the elements of an array from start on as so many rows and columns."""
        return array[start : start + rows * columns].reshape(rows, columns)

    def integers(array: Any, start: int) -> Any:
        """Return what an array of numbers of 64 bits has from start on as integers of 32 bits."""
        return array[start:].view(np.int32)

    def wide_integers(array: Any, start: int) -> Any:
        """Return what an array of numbers of 64 bits has from start on as integers of 64 bits."""
        return array[start:].view(np.int64)

    def outlive(array: Any) -> None:
        """Keep an array until here: views of it hold no reference."""

else:

    def _as_integers(array, number):
        """Return signature and code of what shows numbers of 64 bits as integers of a type."""
        kind = types.Array(number, 1, 'C')

        def codegen(context, builder, signature, values):
            given, first = values
            whole = make_array(array)(context, builder, given)
            (size,) = cgutils.unpack_tuple(builder, whole.shape, 1)
            data = builder.gep(whole.data, [first])
            data = builder.bitcast(data, context.get_data_type(number).as_pointer())
            count = builder.mul(builder.sub(size, first), size.type(64 // number.bitwidth))
            return array_at(context, builder, kind, data, [count])

        return kind(array, types.intp), codegen

    @intrinsic
    def row(typingctx, array, k):
        """Return array[k] of a C-contiguous array of two or three dimensions."""
        kind = types.Array(array.dtype, array.ndim - 1, 'C')

        def codegen(context, builder, signature, values):
            given, number = values
            whole = make_array(array)(context, builder, given)
            shape = cgutils.unpack_tuple(builder, whole.shape, array.ndim)
            stride, *_ = cgutils.unpack_tuple(builder, whole.strides)
            offset = builder.mul(number, stride)
            data = cgutils.pointer_add(builder, whole.data, offset, whole.data.type)
            return array_at(context, builder, kind, data, shape[1:])

        return kind(array, types.intp), codegen

    @intrinsic
    def part(typingctx, array, start, stop):
        """Return array[start:stop] of a contiguous array, 0 <= start <= stop <= its size."""

        def codegen(context, builder, signature, values):
            given, first, end = values
            whole = make_array(array)(context, builder, given)
            data = builder.gep(whole.data, [first])
            return array_at(context, builder, array, data, [builder.sub(end, first)])

        return array(array, types.intp, types.intp), codegen

    @intrinsic
    def table(typingctx, array, start, rows, columns):
        """Return the elements of a contiguous array from start on as so many rows and columns."""
        kind = types.Array(array.dtype, 2, 'C')

        def codegen(context, builder, signature, values):
            given, first, *shape = values
            whole = make_array(array)(context, builder, given)
            return array_at(context, builder, kind, builder.gep(whole.data, [first]), shape)

        return kind(array, types.intp, types.intp, types.intp), codegen

    @intrinsic
    def integers(typingctx, array, start):
        """Return what an array of numbers of 64 bits has from start on as integers of 32 bits."""
        return _as_integers(array, types.int32)

    @intrinsic
    def wide_integers(typingctx, array, start):
        """Return what an array of numbers of 64 bits has from start on as integers of 64 bits."""
        return _as_integers(array, types.int64)

    @intrinsic
    def outlive(typingctx, array):
        """Keep an array until here: views of it hold no reference."""

        def codegen(context, builder, signature, values):
            return context.get_dummy_value()

        return types.none(array), codegen
