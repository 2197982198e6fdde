"""Maximum of two numbers in a form that LLVM vectorises.

A maximum over a loop by ``max`` or ``if`` is evaluated one by one, because with NaN or zeros of
both signs the order would matter. ``larger`` declares that it does not matter (LLVM Language
Reference, *Fast-Math Flags*: ``nnan``, ``nsz``), which Numba's ``fastmath`` does not do for a
selection. Then four to eight numbers are compared at once.
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
    """Return the signature of ``larger`` in compiled code, and its code generator."""

    def write(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        is_first = builder.fcmp_ordered('>', *arguments, flags=_FLAGS)
        return builder.select(is_first, *arguments, flags=_FLAGS)

    return types.float64(types.float64, types.float64), write


larger = _larger if config.DISABLE_JIT else _compiled_larger
