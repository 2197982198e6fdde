"""Gives memory back to the system once large answers are gone, and without long pauses.

glibc serves large blocks from its heaps as soon as one of them was freed (the threshold above
which a block is mapped by itself grows to 32 MB), and a heap shrinks only from its end. A fixed
threshold keeps large blocks out of the heaps, so that freeing them is giving them back.

It also keeps freed blocks of up to 128 bytes in lists of their own (fastbins), and merges them all
when a block of 64 KB is freed. Those of the tree of a URDF of 4000 links take 10 ms, in which
Python's interpreter lock is held and no cycle begins. Without such lists each is merged at once.

Python looks for garbage now and then among all objects that there are, and nothing else runs
meanwhile: with a compiler loaded and a scene of 1000 bodies that takes 60 to 130 ms.
"""

from __future__ import annotations

import ctypes
import gc

_M_MXFAST, _M_MMAP_THRESHOLD = 1, -3  # malloc.h
# Above what cycles of a robot's scene allocate, and images of 640 x 480, which would pay for
# mapping anew each time: 780 faults an image; three cameras took 58 images a second, now 66.
_LARGE = 1 << 21  # [bytes]
# Searches of all but the oldest objects between two of all; each follows 7000 new objects.
_RARELY = 1000


def give_back_blocks() -> bool:
    """Have blocks of 2 MB and more mapped by themselves, and small ones merged when freed.

    Return whether that is possible.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):  # another C library
        return False
    return bool(mallopt(_M_MMAP_THRESHOLD, _LARGE)) and bool(mallopt(_M_MXFAST, 0))


def settle() -> None:
    """Leave what is there now out of what is searched for garbage, until this is called again.

    And search all of the rest rarely: a request of 100 000 points would be a reason to do so, and
    its objects are no garbage.
    """
    young, middle, _ = gc.get_threshold()
    gc.set_threshold(young, middle, _RARELY)
    gc.unfreeze()
    gc.collect()
    gc.freeze()


def leave_out_of_searches() -> None:
    """Leave what is there now out as well, garbage included, without looking for that before.

    For what a large scene is made of, which is there to stay.
    """
    gc.freeze()
