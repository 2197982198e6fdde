"""How a time budget is spent: kernels for the nearest pairs first, in blocks, while time lasts.

A look at the clock and a compiled call cost some microseconds, as much as a hundred closed forms,
and one pair of hulls may cost that too. So a block is made for half of the time that is left, by
what pairs cost lately, within limits. Where all pairs fit into the budget by that cost, they need
neither an order nor blocks.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]

# Pairs. The first block is computed whatever the budget is: the nearest pairs are always sharp,
# and a scene that rests becomes so. The longest is as far as a budget is overrun by pairs that
# turn out to cost more than those before.
SHORTEST_BLOCK = 8
LONGEST_BLOCK = 256
# The cost of a pair is that of the dearest block lately: it fades by this factor [-] a block.
FADING = 0.75


class Pace:
    """What pairs cost lately, kept from query to query."""

    def __init__(self) -> None:
        self.seconds_a_pair = 0.0

    def spend(
        self,
        distances: Floats,
        compute: Callable[[Indices], None],
        end: float,
        reserve: float = 0.0,
    ) -> Indices:
        """Call ``compute`` with blocks of pair numbers, nearest first; return those left.

        ``distances`` (k,) [m] are certified least distances of the pairs, ``end`` [s] is a moment
        of ``time.perf_counter``, and ``reserve`` [s] what a pair that is left costs later.
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
        """Take to heart what so many pairs cost; a few tell little."""
        if pairs >= SHORTEST_BLOCK or self.seconds_a_pair <= 0.0 < pairs:
            self.seconds_a_pair = max(seconds / pairs, FADING * self.seconds_a_pair)

    def fits(self, pairs: int, seconds: float) -> bool:
        """Tell whether so many pairs should cost no more than ``seconds``."""
        return 0.0 < self.seconds_a_pair * pairs <= seconds

    def _block(self, left: float) -> int:
        """Return how many pairs to compute in half of the time [s] that is left."""
        if self.seconds_a_pair <= 0.0:
            return SHORTEST_BLOCK
        fitting = int(min(0.5 * left / self.seconds_a_pair, LONGEST_BLOCK))
        return max(fitting, SHORTEST_BLOCK)
