"""Gives memory back to the system once large answers are gone.

glibc serves large blocks from its heaps as soon as one of them was freed (the threshold above
which a block is mapped by itself grows to 32 MB), and a heap shrinks only from its end. A fixed
threshold keeps large blocks out of the heaps, so that freeing them is giving them back.
"""

from __future__ import annotations

import ctypes

_M_MMAP_THRESHOLD = -3  # malloc.h
# Far above what cycles of a robot's scene allocate, which would pay for mapping anew each time.
_LARGE = 1 << 18  # [bytes]


def give_back_large_blocks() -> bool:
    """Have blocks of 256 kB and more mapped by themselves; return whether that is possible."""
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):  # another C library
        return False
    return bool(mallopt(_M_MMAP_THRESHOLD, _LARGE))
