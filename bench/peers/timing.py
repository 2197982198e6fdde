"""Time per cycle of several libraries that take turns, so that machine noise meets all of them."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import fmean, median
from typing import Any

import numpy as np

MOST_CYCLES = 301
FEWEST_CYCLES = 7
TURN_CYCLES = 10  # in a row: in a loop of its own a library finds the processor's caches warm
WARM_CYCLES = 3  # the first compiles, or fills caches; the last tells how long a cycle takes


@dataclass(frozen=True)
class Turn:
    """What a library does in its turn: pose everything, then ask one query.

    ``layouts`` are the poses of successive cycles as the library takes them; ``query`` reads
    all results as arrays and returns how many there are.
    """

    layouts: list[Any]
    set_poses: Callable[[Any], None]
    query: Callable[[], int]

    def take(self, cycle: int) -> tuple[float, float, int]:
        """Return the seconds of a cycle, those of them that posing took, and its results."""
        poses = self.layouts[back_and_forth(cycle, len(self.layouts))]
        start = time.perf_counter()
        self.set_poses(poses)
        posed = time.perf_counter()
        found = self.query()
        return time.perf_counter() - start, posed - start, found


@dataclass
class Taken:
    """What one library took, by cycle; why it was left out, if it was.

    ``posing`` are those of the ``seconds`` that set_poses took; some libraries put work off until
    the query.
    """

    seconds: list[float] = field(default_factory=list)
    posing: list[float] = field(default_factory=list)
    found: list[int] = field(default_factory=list)
    left_out: str = ''

    def median(self) -> float | None:
        """Return the median time of a cycle [s]; None for a library that was left out."""
        return None if self.left_out else median(self.seconds)

    def mean(self) -> float | None:
        """Return the mean time of a cycle [s]; None for a library that was left out."""
        return None if self.left_out else fmean(self.seconds)

    def worst(self) -> float | None:
        """Return the 99th percentile of the cycles [s]; None for a library that was left out."""
        return None if self.left_out else float(np.percentile(self.seconds, 99))

    def mean_found(self) -> float | None:
        """Return the mean number of results of a cycle."""
        return None if self.left_out else sum(self.found) / len(self.found)


def interleave(
    turns: dict[str, Turn],
    seconds: float,
    limits: dict[str, float],
    in_a_row: int = TURN_CYCLES,
    pause: float = 0.0,
) -> dict[str, Taken]:
    """Let libraries take turns of some cycles each, for about some seconds in all.

    Before each cycle the process sleeps for a ``pause`` [s], if there is one. A library whose
    cycle takes longer than its limit [s], or that raises, is left out. Everybody sees the same
    poses in the same cycle; who begins changes from one round to the next.
    """
    taken = {name: Taken() for name in turns}
    # Before the cycles that warm up: after the garbage of a large scene the next allocation, in
    # whoever comes first, puts all free memory in order, for up to 180 ms.
    gc.collect()
    gc.disable()
    try:
        costs = {name: _warm(turn, taken[name], limits[name]) for name, turn in turns.items()}
        names = [name for name in turns if not taken[name].left_out]
        total = sum(costs[name] + pause for name in names)
        cycles = min(max(int(seconds / max(total, 1e-9)), FEWEST_CYCLES), MOST_CYCLES)
        for start in range(0, cycles, in_a_row):
            first = start // in_a_row % max(len(names), 1)
            for name in names[first:] + names[:first]:
                for cycle in range(start, min(start + in_a_row, cycles)):
                    if pause > 0.0:
                        time.sleep(pause)
                    spent, posing, found = turns[name].take(WARM_CYCLES + cycle)
                    taken[name].seconds.append(spent)
                    taken[name].posing.append(posing)
                    taken[name].found.append(found)
    finally:
        gc.enable()
    return taken


def _warm(turn: Turn, taken: Taken, limit: float) -> float:
    """Return the seconds of a cycle after the first; note why the library is left out."""
    spent = 0.0
    try:
        for cycle in range(WARM_CYCLES):
            spent, _, _ = turn.take(cycle)
            if cycle and spent > limit:
                break
    except Exception as error:  # whatever a library raises for a scene that it cannot answer
        lines = str(error).splitlines() or [type(error).__name__]
        taken.left_out = f'raised: {lines[0][:120]}'
    if spent > limit:
        taken.left_out = f'takes {spent:.2g} s a cycle, more than {limit:g} s'
    return spent


def back_and_forth(number: int, length: int) -> int:
    """Return the place in a walk over 0 ... length - 1 and back: steps of one, for ever."""
    period = max(2 * (length - 1), 1)
    return length - 1 - abs(number % period - (length - 1))
