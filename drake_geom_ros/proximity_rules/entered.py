"""Which rules are entered, since when, and what for: arrays (r,), a step for all at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules.decisions import Limits
from drake_geom_ros.proximity_rules.rule import Why

Ids = NDArray[np.int64]
_AT_ONCE = (Why.STALE, Why.NO_POSE)  # to wait would be to trust what is not known


class Entered:
    """The states of rules; times [s] are of one clock that never runs back."""

    def __init__(self, count: int) -> None:
        self.is_entered = np.zeros(count, dtype=np.bool_)
        self.since = np.full(count, -math.inf)  # of the last change
        self.why = np.zeros(count, dtype=np.uint8)  # a Why; 0: not entered
        self._wanted_since = np.full(count, math.inf)  # of a reason without a break

    def of(self, numbers: Sequence[int]) -> Entered:
        """Return the states of these rules; -1: of one that is new."""
        other, kept = Entered(len(numbers)), [n for n in numbers if n >= 0]
        at = [place for place, n in enumerate(numbers) if n >= 0]
        for name, values in vars(self).items():
            vars(other)[name][at] = values[kept]
        return other

    def step(
        self, now: float, why: NDArray[np.uint8], may_leave: NDArray[np.bool_], limits: Limits
    ) -> Ids:
        """Enter and leave rules by what holds ``now``; return the numbers of those that changed.

        ``why`` is that of ``Limits.why``. What a rule is entered for follows it.
        """
        wanted = why > 0
        self._wanted_since = np.where(wanted, np.minimum(self._wanted_since, now), math.inf)
        is_due = np.isin(why, _AT_ONCE) | (now - self._wanted_since >= limits.enter_after)
        enters = ~self.is_entered & wanted & is_due
        leaves = self.is_entered & may_leave & (now - self.since >= limits.hold)
        changed = enters | leaves
        self.is_entered ^= changed
        self.since[changed] = now
        self.why = np.where(self.is_entered, np.where(wanted, why, self.why), 0).astype(np.uint8)
        return np.flatnonzero(changed)
