"""Tables of kernel addresses, and calls by address."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

Address: TypeAlias = Any  # an integer; uncompiled, the function
Addresses: TypeAlias = Any  # (rows,) integers; uncompiled, a list of functions


def address_table(rows: int) -> Addresses:
    """Return an empty table for the addresses of ``rows`` kernels."""
    if config.DISABLE_JIT:
        return [None] * rows
    return np.zeros(rows, dtype=np.intp)


def caller(signature: Any) -> Any:
    """Return ``call(address, *arguments)`` for compiled functions of this signature.

    The call goes through the C wrapper. Numba sees no error that it could return, so it counts no
    references to the arrays, which took a third of the narrow phase of 1000 balls.
    """
    if config.DISABLE_JIT:
        # Uncompiled, the address is the function itself.
        return lambda address, *arguments: address(*arguments)

    @intrinsic
    def call(typingctx: Any, address: Any, *arguments: Any) -> Any:
        if len(arguments) == 1 and isinstance(arguments[0], types.BaseTuple):
            arguments = tuple(arguments[0])  # as the lowering sees them
        if arguments != signature.args:
            return None

        def codegen(context: Any, builder: Any, _: Any, values: Any) -> Any:
            pointer, packed = values
            unpacked = [builder.extract_value(packed, k) for k in range(len(arguments))]
            argument_types = [context.get_value_type(t) for t in arguments]
            function_type = ir.FunctionType(ir.IntType(8).as_pointer(), argument_types)
            function = builder.inttoptr(pointer, function_type.as_pointer())
            builder.call(function, unpacked)
            return context.get_dummy_value()

        return types.void(address, types.StarArgTuple.from_types(arguments)), codegen

    return call
