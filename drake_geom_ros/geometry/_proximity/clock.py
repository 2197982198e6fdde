"""The steady clock in compiled code: the seconds of ``time.perf_counter``."""

from __future__ import annotations

import time
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

if config.DISABLE_JIT:

    def now() -> float:
        """Return the time [s]."""
        return time.perf_counter()

else:
    _CLOCK = time.CLOCK_MONOTONIC  # which is what perf_counter reads where POSIX holds

    @intrinsic
    def now(typingctx: Any) -> Any:
        """Return the time [s]."""

        def codegen(context, builder, signature, values):  # type: ignore[no-untyped-def]
            long, int32 = ir.IntType(64), ir.IntType(32)
            timespec = ir.LiteralStructType([long, long])
            kind = ir.FunctionType(int32, [int32, timespec.as_pointer()])
            function = cgutils.get_or_insert_function(builder.module, kind, 'clock_gettime')
            told = cgutils.alloca_once(builder, timespec)
            builder.call(function, [ir.Constant(int32, _CLOCK), told])
            double, zero = ir.DoubleType(), cgutils.gep_inbounds(builder, told, 0, 0)
            seconds = builder.sitofp(builder.load(zero), double)
            one = cgutils.gep_inbounds(builder, told, 0, 1)
            nanoseconds = builder.sitofp(builder.load(one), double)
            return builder.fadd(seconds, builder.fdiv(nanoseconds, ir.Constant(double, 1e9)))

        return types.float64(), codegen
