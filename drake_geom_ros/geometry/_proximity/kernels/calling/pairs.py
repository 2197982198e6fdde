"""Calling convention of pair kernels: one result layout, one signature, calls by address.

The engine makes one compiled call per query, and each pair goes to the kernel of its row in the
pair table. Passing Numba a tuple of functions would compile all of them with the caller, and
boxing first-class functions costs 100 us each (measured, Numba 0.68). So a kernel is compiled
alone, when a scene first has such a pair, and the caller gets an array of addresses.

Under ``NUMBA_DISABLE_JIT=1`` an "address" is the Python function itself.
"""

from typing import Any, NamedTuple

from numba import types

from drake_geom_ros.geometry._proximity.runtime.addresses import caller
from drake_geom_ros.geometry._proximity.runtime.arrays import Floats, Vector
from drake_geom_ros.geometry._proximity.runtime.compiled import address_of, inlined

# Columns of a result row.
DISTANCE = 0
NORMAL = 1  # 3: nhat_BA_W
WITNESS_A = 4  # 3: p_ACa_W
WITNESS_B = 7  # 3: p_ACb_W
ERROR_BOUND = 10  # |distance - phi| <= error_bound
UNIQUE = 11  # 1 where nhat_BA_W is unique, else 0
METHOD = 12  # a number of ``kinds.Method``
PAIR_WIDTH = 13
# Columns that follow the answer in the slot of a pair (``pairs.slots``).
SLACK = 13
SEEN = 14
LEVEL_GAP = 15
SLOT_WIDTH = 16  # two cache lines
# Further columns of a slot for the memory of a kernel of two hulls (``remembered``): with them a
# slot takes eight cache lines.
MEMORY_WIDTH = 48


class OrientedShape(NamedTuple):
    """A shape of a pair with its orientation; the position is passed separately, as p_AB_W."""

    kind: int  # shape type number, for the kernel that serves many pairs
    shape: Floats  # parameters
    R_W: Floats  # (3, 3) its orientation in World, C order


class Aim(NamedTuple):
    """Accuracy goal of a kernel call."""

    size: float  # [m] of the pair's shapes
    tolerance: float  # [m]
    cutoff: float  # [m]
    accuracy: float  # [m] the largest error that is wanted, 0: as ``tolerance`` says


_vector = types.float64[::1]
_matrix = types.float64[:, ::1]
_shape = types.NamedTuple([types.int64, _vector, _matrix], OrientedShape)
PAIR_SIGNATURE = types.void(
    _shape, _shape, _vector, types.NamedUniTuple(types.float64, 4, Aim), _vector
)


@inlined
def write(
    out: Floats,
    distance: float,
    nhat_BA_W: Vector,
    p_ACa_W: Vector,
    p_ACb_W: Vector,
    error_bound: float,
    unique: bool,
    method: int,
) -> None:
    """Write one result row."""
    out[DISTANCE] = distance
    out[ERROR_BOUND] = error_bound
    out[UNIQUE] = 1.0 if unique else 0.0
    out[METHOD] = method
    for k in range(3):
        out[NORMAL + k] = nhat_BA_W[k]
        out[WITNESS_A + k] = p_ACa_W[k]
        out[WITNESS_B + k] = p_ACb_W[k]


def compiled_address(function: Any, signature: Any = PAIR_SIGNATURE) -> Any:
    """Compile a function, or load it from the cache on disk, and return its address."""
    return address_of(function, signature)


call_kernel = caller(PAIR_SIGNATURE)
