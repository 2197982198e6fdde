"""Steady clock for compiled code, equal to ``time.perf_counter``."""

from __future__ import annotations

import time
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

if config.DISABLE_JIT:

    def now() -> float:
        """Return the steady time [s]."""
        return time.perf_counter()

else:
    _CLOCK = time.CLOCK_MONOTONIC  # the clock of perf_counter on POSIX systems

    @intrinsic
    def now(typingctx: Any) -> Any:
        """Return the steady time [s]."""

        def codegen(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            long, int32 = ir.IntType(64), ir.IntType(32)
            timespec = ir.LiteralStructType([long, long])
            kind = ir.FunctionType(int32, [int32, timespec.as_pointer()])
            function = builder.module.globals.get('clock_gettime')
            if function is None:
                function = ir.Function(builder.module, kind, 'clock_gettime')
            with builder.goto_entry_block():  # so a loop does not allocate it each time
                now_spec = builder.alloca(timespec)
            builder.call(function, [ir.Constant(int32, _CLOCK), now_spec])
            read, double = builder.load(now_spec), ir.DoubleType()
            seconds = builder.sitofp(builder.extract_value(read, 0), double)
            nanoseconds = builder.sitofp(builder.extract_value(read, 1), double)
            return builder.fadd(seconds, builder.fdiv(nanoseconds, ir.Constant(double, 1e9)))

        return types.float64(), codegen
