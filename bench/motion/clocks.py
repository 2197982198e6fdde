"""Times of a side, one thing after the other, by the processor."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def clocked(work: Callable[[Any], Any], each: Any) -> tuple[list[Any], Floats]:
    """Return the results for each of some things, and the processor times [s]."""
    results, seconds = [], []
    for one in each:
        start = time.process_time()
        results.append(work(one))
        seconds.append(time.process_time() - start)
    return results, np.array(seconds)


def told(name: str, seconds: Floats) -> None:
    """Print the mean, the median and the 99th percentile of times [s]."""
    mean, median, slow = seconds.mean(), np.median(seconds), np.percentile(seconds, 99)
    print(f'  {name}: mean {1e6 * mean:.0f} us, median {1e6 * median:.0f}, p99 {1e6 * slow:.0f}')
