"""Which rules are entered, since when, and what for: arrays (r,), a step for all at once."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.proximity_rules.decisions import Limits

Ids = NDArray[np.int64]
Whys = NDArray[np.uint8]


class Entered:
    """The states of rules; times [s] are of one clock that never runs back."""

    def __init__(self, count: int) -> None:
        self.is_entered = np.zeros(count, dtype=np.bool_)
        self.since = np.full(count, -math.inf)  # of the last change
        self.why = np.zeros(count, dtype=np.uint8)  # a Why, of the last time; 0: never entered
        self._near_since = np.full(count, math.inf)  # without a break

    def of(self, numbers: Sequence[int]) -> Entered:
        """Return the states of these rules; -1: of one that is new."""
        other, kept = Entered(len(numbers)), [n for n in numbers if n >= 0]
        at = [place for place, n in enumerate(numbers) if n >= 0]
        for name, values in vars(self).items():
            vars(other)[name][at] = values[kept]
        return other

    def step(
        self, now: float, near: Whys, blind: Whys, may_leave: NDArray[np.bool_], limits: Limits
    ) -> Ids:
        """Enter and leave rules by what holds ``now``; return the numbers of those that changed.

        ``near`` and ``blind`` are those of ``Limits``. What a rule is entered for follows them;
        of one that is left it stays.
        """
        self._near_since = np.where(near > 0, np.minimum(self._near_since, now), math.inf)
        is_due = now - self._near_since >= limits.enter_after
        why = np.where(is_due & (near > 0), near, blind)
        leaves = self.is_entered & may_leave & (now - self.since >= limits.hold)
        changed = (~self.is_entered & (why > 0)) | leaves
        self.is_entered ^= changed
        self.since[changed] = now
        self.why = np.where(self.is_entered & (why > 0), why, self.why)
        return np.flatnonzero(changed)
