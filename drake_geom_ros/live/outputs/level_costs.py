"""The cost of each accuracy level in the last second, for ~/cycle_report.

Cycles only count the pairs that they compute. Once a second, while somebody reads the report, a
sample of the near pairs is computed at every level, on a snapshot of the scene and beside the
cycles; what a pair of it takes, times the pairs that the cycles computed, is the answer.
"""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.live.scene.live_scene import LiveScene

PERIOD = 1.0  # [s] between two measurements


@dataclass(frozen=True)
class Costs:
    """Seconds that a second of cycles takes at each level; empty where none was computed."""

    levels: list[str] = field(default_factory=list)
    seconds: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))  # [s]
    samples: int = 0


class LevelCosts:
    """Counts for the cycles, measures for the report; both may be in threads of their own."""

    def __init__(self, live: LiveScene, publisher: Any) -> None:
        """Measure while ``publisher``, that of the report, has a subscriber."""
        self._live = live
        self._publisher = publisher
        self._lock = threading.Lock()  # of what is counted
        self._pairs, self._reach = 0, 0.0
        self._since = time.perf_counter()
        self._number = 0
        self.last = Costs()

    def count(self, pairs: int, reach: float) -> None:
        """Count pairs that a cycle computed, within ``reach`` [m]."""
        with self._lock:
            self._pairs += pairs
            self._reach = reach

    def measure(self) -> None:
        """Bring ``last`` up to date; to be called every ``PERIOD``."""
        with self._lock:
            pairs, self._pairs = self._pairs, 0
            now = time.perf_counter()
            since, self._since = self._since, now
            reach = self._reach
        if not pairs or not self._publisher.get_subscription_count():
            self.last = Costs()
            return
        self._number += 1
        query = self._live.view().query
        seconds_a_pair, samples = query.cost_of_levels(reach, seed=self._number)
        rate = pairs / (now - since)
        seconds = rate * np.array(list(seconds_a_pair.values()))
        self.last = Costs(list(seconds_a_pair), seconds, samples)
