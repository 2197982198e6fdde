"""Handles: records of many arrays, passed to compiled code as one array of addresses.

Numba takes 65 to 95 ns to recognise the type of each array argument, and a query has about eighty:
in a small scene that is longer than its work. So a record that persists from cycle to cycle has a
*handle*, the address and length of each array, from which compiled code makes the record again.
That costs nothing there and counts no references. The maker of a handle owns the arrays, keeps
them alive as long as the handle, and makes a new handle when one of them is replaced. Handles are
invalid in another process and in a copy.

Under ``NUMBA_DISABLE_JIT=1`` a handle is the record itself.
"""

from __future__ import annotations

from ctypes import addressof, c_char
from functools import cache
from itertools import count
from typing import Annotated, Any, TypeAlias, get_args, get_type_hints

import numpy as np
from numba import carray, config, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from drake_geom_ros.geometry._proximity.runtime.compiled import made, numba_inside

# Types of the fields of records: the type of their numbers, and the extents after the first one,
# None for extents that differ from array to array.
Flags: TypeAlias = Annotated[NDArray[np.bool_], np.bool_, ()]
Integers: TypeAlias = Annotated[NDArray[np.int64], np.int64, ()]
BitRows: TypeAlias = Annotated[NDArray[np.int32], np.int32, ()]
IndexPairs: TypeAlias = Annotated[NDArray[np.int64], np.int64, (2,)]
Reals: TypeAlias = Annotated[NDArray[np.float64], np.float64, ()]
RealPairs: TypeAlias = Annotated[NDArray[np.float64], np.float64, (2,)]
Vectors: TypeAlias = Annotated[NDArray[np.float64], np.float64, (3,)]
Bounds: TypeAlias = Annotated[NDArray[np.float64], np.float64, (6,)]
Rows: TypeAlias = Annotated[NDArray[np.float64], np.float64, (None,)]
SingleRows: TypeAlias = Annotated[NDArray[np.float32], np.float32, (None,)]
Bits: TypeAlias = Annotated[NDArray[np.uint8], np.uint8, (None, None)]
Matrices: TypeAlias = Annotated[NDArray[np.float64], np.float64, (3, 3)]

HandleField: TypeAlias = Integers  # of a record of handles
Handle: TypeAlias = Any  # an array of integers; uncompiled, the record


Extents: TypeAlias = tuple[int | None, ...]


@cache  # reading the types of a record takes longer than a query
def _fields(record: type[tuple[Any, ...]]) -> list[tuple[str, type[Any], Extents]]:
    """Return the name, type of number and extents after the first of each field."""
    hints = get_type_hints(record, include_extras=True)
    return [(name, *get_args(hint)[1:]) for name, hint in hints.items()]


def handle_of(record: tuple[Any, ...]) -> Handle:
    """Return the handle of a record of arrays; raise TypeError for an array unlike its field."""
    if config.DISABLE_JIT:
        return record
    numbers: list[int] = []
    for (name, dtype, extents), array in zip(_layout(type(record)), record, strict=True):
        fits = array.dtype == dtype and array.flags.c_contiguous and array.ndim == 1 + len(extents)
        sizes = array.shape[1:]
        varying: tuple[int, ...] = ()
        if sizes != extents:
            extent_pairs = list(zip(extents, sizes, strict=False))
            fits &= all(extent in (None, size) for extent, size in extent_pairs)
            varying = tuple(size for extent, size in extent_pairs if extent is None)
        if not fits:
            raise TypeError(
                f'{type(record).__name__}.{name} is {array.dtype} {array.shape}, or not in one '
                f'piece; it must be {dtype} {("n", *extents)}'
            )
        numbers += (_address(array), len(array), *varying)
    return np.array(numbers, dtype=np.int64)


def _address(array: NDArray[Any]) -> int:
    """Return the address of a contiguous array."""
    if array.size and array.flags.writeable:
        return addressof(c_char.from_buffer(array.data))  # a fifth of the time of what follows
    address: int = array.__array_interface__['data'][0]
    return address


@cache
def _layout(record: type[tuple[Any, ...]]) -> list[tuple[str, np.dtype[Any], Extents]]:
    """Return the name, dtype and extents after the first of each field."""
    return [(name, np.dtype(dtype), extents) for name, dtype, extents in _fields(record)]


@intrinsic
def _pointer(typingctx: Any, address: Any, number: Any) -> Any:
    """Return an address as a pointer to numbers of a type."""

    def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.inttoptr(values[0], context.get_value_type(signature.return_type))

    return types.CPointer(number.dtype)(types.intp, number), codegen


def taker(record: type[tuple[Any, ...]]) -> Any:
    """Return the compiled function that makes a record from its handle."""
    if config.DISABLE_JIT:
        return lambda handle: handle
    if numba_inside is not None:
        return numba_inside.taker(record, _fields(record))
    numbers, arrays = count(), []
    names = {'__name__': __name__, 'record': record, 'carray': carray, 'pointer': _pointer}
    for name, dtype, extents in _fields(record):
        names[name] = dtype
        at = f'pointer(handle[{next(numbers)}], {name})'
        shape = [
            f'handle[{next(numbers)}]' if extent is None else f'{extent}'
            for extent in (None, *extents)
        ]
        arrays.append(f'carray({at}, ({", ".join(shape)},))')
    # As generated source, because Numba unpacks only records whose construction it sees.
    exec(f'def take(handle):\n    return record({", ".join(arrays)})', names)
    return made(names['take'])
