"""Memory that the limits of this process leave."""

from __future__ import annotations

import math
import resource
from pathlib import Path

_STATM = Path('/proc/self/statm')


def free_memory() -> float:
    """Return the memory [bytes] that the limit of this process (``ulimit -v``) leaves.

    inf without a limit, or if the used memory cannot be read. The memory of the machine and the
    limit of a container are not considered, since reclaimable pages count there as used.
    """
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return math.inf
    try:
        used = int(_STATM.read_text().split()[0]) * resource.getpagesize()
    except OSError:
        return math.inf
    return max(0.0, limit - used)
