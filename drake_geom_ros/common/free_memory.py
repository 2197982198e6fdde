"""How much memory this process may still take."""

from __future__ import annotations

import math
import resource
from pathlib import Path

_STATM = Path('/proc/self/statm')


def free_memory() -> float:
    """Return how many bytes the limits of this process (``ulimit -v``) leave it.

    inf where there is no limit, or where what is used cannot be read. What the machine has, and
    a limit of a whole container, are not asked for: pages that could be given back count there.
    """
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return math.inf
    try:
        used = int(_STATM.read_text().split()[0]) * resource.getpagesize()
    except OSError:
        return math.inf
    return max(0.0, limit - used)
