"""The work on very many pairs, shared out to threads, which take neighbouring pairs each.

A pair is answered for itself, so it does not matter which thread does it, nor how many there are.
To hand work to a thread takes some 50 us, and afterwards what each has written is in its own
caches: what is soon done is not shared out (10 000 balls took 5 % longer, 30 000 15 to 25 % less).
``NUMBA_NUM_THREADS`` says how many threads there are; without it, there is one for each core.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from typing import TypeVar

from numba import config

Result = TypeVar('Result')

THREADS = config.NUMBA_NUM_THREADS
LONG = 0.002  # [s] work of one thread that is worth it


@functools.cache
def _pool(niceness: int) -> ThreadPoolExecutor:
    """Return the threads for callers of a niceness: on Linux a thread has that of its starter."""
    return ThreadPoolExecutor(THREADS, thread_name_prefix=f'pairs, nice {niceness}')


# The threads of a process are not there in one that is forked from it.
os.register_at_fork(after_in_child=_pool.cache_clear)


def share(count: int, work: Callable[[int, int], Result]) -> list[Result]:
    """Return what ``work(first, last)`` returns of the parts of so many, in their order.

    All of it is done when this returns, or raises what ``work`` raised.
    """
    ends = [count * k // THREADS for k in range(THREADS + 1)]
    pool = _pool(os.getpriority(os.PRIO_PROCESS, 0))  # of this thread, on Linux
    others = [pool.submit(work, *ends[k : k + 2]) for k in range(1, THREADS)]
    try:
        return [work(*ends[:2]), *(other.result() for other in others)]
    finally:
        wait(others)
