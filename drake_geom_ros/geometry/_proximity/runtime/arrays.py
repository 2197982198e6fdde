"""Types of arrays in compiled code, and conversions of numbers."""

from collections.abc import Callable
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Singles: TypeAlias = NDArray[np.float32]
Indices: TypeAlias = NDArray[np.int64]
Integers32: TypeAlias = NDArray[np.int32]
Integers16: TypeAlias = NDArray[np.int16]
Unsigned32: TypeAlias = NDArray[np.uint32]
Bytes: TypeAlias = NDArray[np.uint8]
Booleans: TypeAlias = NDArray[np.bool_]
Vector: TypeAlias = tuple[float, float, float]

# NumPy's number types, with which Numba computes as C does; a type checker sees Python's. An
# unsigned index needs no test for negative ones, which takes as long as the rest. The sum of a
# signed and an unsigned number is a float, so both operands have to be of one type.
unsigned = cast(Callable[[Any], int], np.uint64)
signed = cast(Callable[[Any], int], np.int64)
unsigned32 = cast(Callable[[Any], int], np.uint32)
signed32 = cast(Callable[[Any], int], np.int32)
single = cast(Callable[[Any], float], np.float32)
