"""Arrays as they are given: pointers to Python's objects, of which compiled code reads the rest.

Numba looks at each array that a compiled function is given: 20 to 40 ns, and 3 us in the first
cycle after other work, when the code that looks comes from memory. A function whose argument is
``GIVEN`` gets the object's address, and ``array_in`` makes the array of it. Whether it is one has
to be known, or asked of ``is_alike``. It is not kept: whoever calls holds it meanwhile. What is
read is NumPy's C interface, ``PyArrayObject_fields``, which stays as it is.

Under ``NUMBA_DISABLE_JIT=1`` an object is itself.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import config, from_dtype, types
from numba.core import cgutils
from numba.extending import NativeValue, intrinsic, models, register_model, unbox

from drake_geom_ros.geometry._proximity.kernels.calling.views import array_at

# Where a number stands in an array object [bytes], behind the count of references and the type.
_HEAD = object.__basicsize__
_TYPE = _HEAD - 8
_DATA, _DIMENSIONS, _EXTENTS, _DTYPE, _FLAGS = (_HEAD + k for k in (0, 8, 16, 40, 48))
_IN_ORDER = 0x0001 | 0x0100  # of the flags: in one piece as in C, and aligned


class _Given(types.Opaque):  # type: ignore[misc]
    """The type of an object that is given by its address."""


GIVEN = _Given('given')
register_model(_Given)(models.OpaqueModel)


@unbox(_Given)
def _unbox(kind: Any, address: Any, c: Any) -> NativeValue:
    return NativeValue(address)


def _read(builder: Any, given: Any, offset: int, kind: Any) -> Any:
    """Return a number of an object in generated code."""
    place = cgutils.pointer_add(builder, given, offset, kind.as_pointer())
    return builder.load(place)


def data_of(builder: Any, given: Any) -> Any:
    """Return where the numbers of an array are, as a pointer to integers, in generated code."""
    return _read(builder, given, _DATA, cgutils.intp_t.as_pointer())


def array_in(number: type[Any], dimensions: int) -> Any:
    """Return the compiled function that takes an object for an array in one piece."""
    if config.DISABLE_JIT:
        return lambda given: given
    kind = types.Array(from_dtype(np.dtype(number)), dimensions, 'C')

    @intrinsic
    def take(typingctx, given):  # type: ignore[no-untyped-def]
        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            element = context.get_data_type(kind.dtype)
            extents = _read(builder, values[0], _EXTENTS, cgutils.intp_t.as_pointer())
            places = (cgutils.gep_inbounds(builder, extents, k) for k in range(dimensions))
            shape = [builder.load(place) for place in places]
            data = builder.bitcast(data_of(builder, values[0]), element.as_pointer())
            return array_at(context, builder, kind, data, shape)

        return kind(given), codegen

    return take


if config.DISABLE_JIT:

    def is_alike(given: Any, ours: Any) -> bool:
        """Tell whether an object is an array of the numbers and dimensions of one of ours."""
        if type(given) is not type(ours) or given.dtype is not ours.dtype:
            return False
        in_order: bool = given.flags.c_contiguous and given.flags.aligned
        return given.ndim == ours.ndim and in_order

else:

    @intrinsic
    def is_alike(typingctx, given, ours):  # type: ignore[no-untyped-def]
        """Tell whether an object is an array of the numbers and dimensions of one of ours.

        And of its type, in one piece, in the order of C.
        """

        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            told = cgutils.alloca_once_value(builder, cgutils.false_bit)

            def same(offset: int, kind: Any) -> Any:
                read = [_read(builder, value, offset, kind) for value in values]
                return builder.icmp_signed('==', *read)

            # Nothing but the type is known to be there before that is known.
            with builder.if_then(same(_TYPE, cgutils.intp_t)):
                flags = _read(builder, values[0], _FLAGS, cgutils.int32_t)
                wanted = flags.type(_IN_ORDER)
                in_order = builder.icmp_signed('==', builder.and_(flags, wanted), wanted)
                alike = builder.and_(
                    same(_DTYPE, cgutils.intp_t), same(_DIMENSIONS, cgutils.int32_t)
                )
                builder.store(builder.and_(in_order, alike), told)
            return builder.load(told)

        return types.boolean(given, ours), codegen
