"""The larger of two numbers, in a form that LLVM turns into one operation on many at a time.

The largest of many numbers in a loop, by ``max`` or an ``if``, is looked for one by one: if one of
them were NaN, or zeros had both signs, the order would matter. ``larger`` says that it does not,
which Numba's ``fastmath`` cannot say of a choice (LLVM Language Reference, *Fast-Math Flags*:
``nnan``, ``nsz``): four to eight numbers are compared at once.
"""

from typing import Any

from numba import config, types
from numba.extending import intrinsic

_FLAGS = ('nnan', 'nsz')


def _larger(a: float, b: float) -> float:
    """Return the larger of two numbers, none of them NaN; either zero for two zeros."""
    return a if a > b else b


@intrinsic
def _compiled_larger(typing: Any, a: Any, b: Any) -> Any:
    """Return the signature of ``larger`` in compiled code, and what writes it."""

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        is_first = builder.fcmp_ordered('>', *arguments, flags=_FLAGS)
        return builder.select(is_first, *arguments, flags=_FLAGS)

    return types.float64(types.float64, types.float64), write


larger = _larger if config.DISABLE_JIT else _compiled_larger
