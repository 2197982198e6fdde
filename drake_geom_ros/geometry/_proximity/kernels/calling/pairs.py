"""How kernels are called: one result layout, one signature, called through an address.

The engine makes one compiled call a query and each pair of it goes to the kernel of its row in
the pair table. Handing Numba a tuple of functions would compile all of them with the caller, and
boxing first-class functions costs 100 us each (measured, Numba 0.68). So a kernel is compiled
alone, when a scene first has such a pair, and the caller gets an array of addresses.

Under ``NUMBA_DISABLE_JIT=1`` an "address" is the Python function itself.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from drake_geom_ros.geometry._proximity.compiled import address_of, inlined

# Columns of a result row.
DISTANCE = 0
NORMAL = 1  # 3: nhat_BA_W
WITNESS_A = 4  # 3: p_ACa_W
WITNESS_B = 7  # 3: p_ACb_W
ERROR_BOUND = 10  # |distance - phi| <= error_bound
UNIQUE = 11  # 1 where nhat_BA_W is unique, else 0
METHOD = 12  # a number of ``kinds.Method``
PAIR_WIDTH = 13
# Columns that follow in the slot of a pair (``records``): what is known of it, beside its answer.
SLACK = 13
SEEN = 14
GAP = 15
SLOT_WIDTH = 16  # two lines of the cache
# Columns that a slot may have beyond, for what a kernel of two hulls remembers (``remembered``):
# with them it takes eight lines of the cache.
MEMORY_WIDTH = 48

_vector = types.float64[::1]
_matrix = types.float64[:, ::1]
PAIR_SIGNATURE = types.void(
    types.int64,
    _vector,
    _matrix,
    types.int64,
    _vector,
    _matrix,
    _vector,
    types.float64,
    types.float64,
    _vector,
)


@inlined
def write(out, distance, nhat_BA_W, p_ACa_W, p_ACb_W, error_bound, unique, method):
    """Fill one result row."""
    out[DISTANCE] = distance
    out[ERROR_BOUND] = error_bound
    out[UNIQUE] = 1.0 if unique else 0.0
    out[METHOD] = method
    for k in range(3):
        out[NORMAL + k] = nhat_BA_W[k]
        out[WITNESS_A + k] = p_ACa_W[k]
        out[WITNESS_B + k] = p_ACb_W[k]


def address_table(rows: int) -> Any:
    """Return an empty table for the addresses of ``rows`` kernels."""
    if config.DISABLE_JIT:
        return [None] * rows
    return np.zeros(rows, dtype=np.intp)


def compiled_address(function: Any, signature: Any = PAIR_SIGNATURE) -> Any:
    """Compile a function, or load it from the cache on disk, and return its address."""
    return address_of(function, signature)


def caller(signature: Any) -> Any:
    """Return ``call(address, *arguments)`` for compiled functions of this signature.

    The call goes through the C wrapper. It is opaque to Numba, which sees no error that it might
    return, and so counts no references to the arrays (a third of the narrow phase of 1000 balls).
    """
    if config.DISABLE_JIT:
        # Uncompiled, the address is the function.
        return lambda address, *arguments: address(*arguments)

    @intrinsic
    def call(typingctx, address, *arguments):
        if len(arguments) == 1 and isinstance(arguments[0], types.BaseTuple):
            arguments = tuple(arguments[0])  # as the lowering sees them
        if arguments != signature.args:
            return None

        def codegen(context, builder, _, values):
            pointer, packed = values
            unpacked = [builder.extract_value(packed, k) for k in range(len(arguments))]
            argument_types = [context.get_value_type(t) for t in arguments]
            function_type = ir.FunctionType(ir.IntType(8).as_pointer(), argument_types)
            function = builder.inttoptr(pointer, function_type.as_pointer())
            builder.call(function, unpacked)
            return context.get_dummy_value()

        return types.void(address, types.StarArgTuple.from_types(arguments)), codegen

    return call


call_kernel = caller(PAIR_SIGNATURE)
