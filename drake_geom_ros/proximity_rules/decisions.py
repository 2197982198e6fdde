"""Whether rules are entered and left, for all rules at once.

What decides is the lower bound of a distance, which is certified: a rule may be entered early
where an answer is loose, and never late.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules.rule import ProximityRule, Why

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Whys = NDArray[np.uint8]


class Poses(NamedTuple):
    """Which geometries (n,), in the order of ``WatchedPairs.ids``, stand where they stood."""

    stale: Flags  # posed too long ago, or hang on what is
    absent: Flags  # never posed, or hang on what is not


class Reasons(NamedTuple):
    """What each rule (r,) would be entered for, and what keeps it entered."""

    lowest: Floats  # [m] the least lower bound of its pairs; inf: none was near enough to see
    soonest: Floats  # [s] the least time to contact; inf: nothing that closes
    stale: Flags  # it needs a pose that is stale
    absent: Flags  # or that never came
    unpredicted: Flags  # times count for it, and nobody knows how all that it needs moves


class Limits:
    """The numbers of rules as arrays (r,), to decide about all at once."""

    def __init__(self, rules: Sequence[ProximityRule]) -> None:
        def each(field: str) -> Floats:
            return np.array([getattr(rule, field) for rule in rules], dtype=np.float64)

        self.enter, self.leave = each('enter'), each('leave')
        self.hold, self.enter_after = each('hold'), each('enter_after')
        self.least_time = each('min_time_to_contact')
        self._farthest = each('farthest')
        self._farthest_at_rest = float(self._farthest.max(initial=-math.inf))
        self.enters_when_stale = each('enters_when_stale').astype(np.bool_)

    def farthest(self, fastest: float) -> float:
        """Return how far [m] a pair counts, where pairs close at most this fast [m/s]."""
        if not fastest:
            return self._farthest_at_rest
        each = np.maximum(self._farthest, self.least_time * fastest)
        return float(each.max(initial=-math.inf))

    def near(self, reasons: Reasons) -> Whys:
        """Return why each rule would be entered after ``enter_after``, as a ``Why``; 0: not."""
        soon = np.where(reasons.soonest < self.least_time, np.uint8(Why.SOON), np.uint8(0))
        return np.where(reasons.lowest < self.enter, np.uint8(Why.NEAR), soon)

    def blind(self, reasons: Reasons) -> Whys:
        """Return why each rule would be entered at once: to wait were to trust the unknown."""
        stale = np.where(reasons.stale, np.uint8(Why.STALE), np.uint8(0))
        whys = np.where(reasons.absent, np.uint8(Why.NO_POSE), stale)
        return np.where(self.enters_when_stale, whys, np.uint8(0))

    def may_leave(self, reasons: Reasons) -> Flags:
        """Return which rules nothing keeps entered, but for ``hold``.

        A pose that is stale or absent keeps a rule entered whatever ``when_stale`` says, and so
        does a motion that is not known where times to contact count.
        """
        far = (reasons.lowest >= self.leave) & (reasons.soonest >= self.least_time)
        return far & ~reasons.stale & ~reasons.absent & ~reasons.unpredicted
