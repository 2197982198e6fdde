"""Spending of a time budget: kernels run for the nearest pairs first, in blocks, until it ends.

Reading the clock and making a compiled call cost some microseconds, as much as a hundred closed
forms or one pair of hulls. So a block is sized, within limits, for half of the remaining time at
the recent cost of a pair. Where all pairs fit into the budget at that cost, they are neither
sorted nor split into blocks.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Pairs in a block. The first block is computed whatever the budget is, so the nearest pairs are
# always sharp and a resting scene becomes so. The longest block limits how far pairs that turn out
# costlier than the previous ones overrun a budget.
SHORTEST_BLOCK = 8
LONGEST_BLOCK = 256
# The cost of a pair is that of the costliest recent block, fading by this factor [-] per block.
FADING = 0.75


class Pace:
    """Recent cost of a pair, carried from query to query."""

    def __init__(self) -> None:
        self.seconds_a_pair = 0.0

    def spend(
        self,
        distances: Floats,
        compute: Callable[[Indices], None],
        end: float,
        reserve: float = 0.0,
    ) -> Indices:
        """Call ``compute`` with blocks of pair numbers, nearest first; return the rest.

        Args:
            distances: (k,) certified lower bounds of the distances of the pairs [m].
            compute: computes the pairs of a block.
            end: moment of ``time.perf_counter`` at which the budget ends [s].
            reserve: time that each pair left over costs afterwards [s].
        """
        order = np.argsort(distances, kind='stable')
        done, now = 0, time.perf_counter()
        while done < len(order):
            left = end - now - reserve * (len(order) - done)
            if done and left < self.seconds_a_pair:
                break
            block = order[done : done + self._block(left)]
            compute(block)
            done += len(block)
            before, now = now, time.perf_counter()
            self.learn(len(block), now - before)
        return order[done:]

    def learn(self, pairs: int, seconds: float) -> None:
        """Update the cost of a pair, unless there were too few pairs to measure it."""
        if pairs >= SHORTEST_BLOCK or self.seconds_a_pair <= 0.0 < pairs:
            self.seconds_a_pair = max(seconds / pairs, FADING * self.seconds_a_pair)

    def fits(self, pairs: int, seconds: float) -> bool:
        """Return whether ``pairs`` pairs are expected to cost no more than ``seconds``."""
        return 0.0 < self.seconds_a_pair * pairs <= seconds

    def _block(self, left: float) -> int:
        """Return the number of pairs to compute in half of the remaining time ``left`` [s]."""
        if self.seconds_a_pair <= 0.0:
            return SHORTEST_BLOCK
        fitting = int(min(0.5 * left / self.seconds_a_pair, LONGEST_BLOCK))
        return max(fitting, SHORTEST_BLOCK)
