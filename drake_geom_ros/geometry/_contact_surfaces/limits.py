"""Limits on the work for contact surfaces."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple


class Limit(NamedTuple):
    """A number of steps, each some 10 to 100 ns, a time, and whether nobody waits any more."""

    steps: float = math.inf
    seconds: float = math.inf
    must_stop: Callable[[], bool] = bool  # asked between blocks of steps


UNLIMITED = Limit()
