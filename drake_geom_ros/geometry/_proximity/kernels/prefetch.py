"""Cache lines that are asked for before they are needed: for loops that go to and fro in memory.

Where thousands of bodies do not fit into the nearer caches, most of the time of such a loop is
waiting. (30 000 balls at robot speed: 10.7 -> 8.5 ms a cycle; of 1000 balls nothing is gained.)
"""

from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.arrayobj import make_array

from drake_geom_ros.geometry._proximity.compiled import inlined

AHEAD = 32  # turns of a loop; half as many leave some of the wait, twice as many gain nothing
MANY = 4096  # turns; what fewer of them read is in the nearer caches, and to ask costs 2 %


@inlined
def until(turns: int) -> int:
    """Return up to which of so many turns the loop asks for what it reads AHEAD turns later."""
    return turns - AHEAD if turns > MANY else 0


if config.DISABLE_JIT:

    def prefetch(array: Any, place: tuple[int, ...]) -> None:
        """Ask for the cache line in which array[place] begins."""

else:

    @intrinsic
    def prefetch(typingctx, array, place):
        """Ask for the cache line in which array[place] begins."""

        def codegen(context, builder, signature, values):
            whole = make_array(array)(context, builder, values[0])
            numbers = cgutils.unpack_tuple(builder, values[1])
            strides = cgutils.unpack_tuple(builder, whole.strides)
            address = whole.data
            for number, stride in zip(numbers, strides, strict=False):
                address = cgutils.pointer_add(builder, address, builder.mul(number, stride))
            address = builder.bitcast(address, ir.IntType(8).as_pointer())
            number = ir.IntType(32)
            kind = ir.FunctionType(ir.VoidType(), [address.type, number, number, number])
            function = cgutils.get_or_insert_function(builder.module, kind, 'llvm.prefetch.p0i8')
            builder.call(function, [address, number(0), number(3), number(1)])
            return context.get_dummy_value()

        return types.none(array, types.UniTuple(types.intp, len(place))), codegen
