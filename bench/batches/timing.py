"""Times of ours and of another library, in turns."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from drake_geom_ros.batch import evaluate

TURNS = 3  # of which the fastest counts: what else the machine does only ever adds


def seconds(work: Callable[[], Any], clock: Callable[[], float] = time.perf_counter) -> float:
    """Return the least time [s] of some turns."""
    taken = []
    for _ in range(TURNS):
        start = clock()
        work()
        taken.append(clock() - start)
    return min(taken)


def sides(ours: Ours) -> list[Any]:
    """Return the libraries that are installed here; all get the pairs that pydrake can filter."""
    found: list[Any] = []
    try:
        from bench.batches.drake_side import DrakeSide

        drake = DrakeSide(ours)
        ours.keep_only(drake.pairs())
        drake.keep_only(ours.pairs())
        print(f'the same pairs of geometries: {ours.pairs() == drake.pairs()}')
        found.append(drake)
    except ImportError as error:
        print(f'not installed here, left out: pydrake ({error})')
    try:
        from bench.batches.other_sides import CoalSide, MujocoSide

        found += [CoalSide(ours), MujocoSide(ours)]
    except ImportError as error:
        print(f'not installed here, left out: Coal with Pinocchio, MuJoCo ({error})')
    return found


def beside(ours: Ours, other: Any, states: np.ndarray) -> None:
    """Print ours and another library's times by state, one thread each."""
    few = states[:200]
    mine = ask(ours, few, 'least', 1).distance
    off, apart = np.abs(mine - other.least(few)), mine > 0.0
    differ = int((ask(ours, few, 'collision', 1) != other.collisions(few)).sum())
    print(
        f'{other.name}: least distances differ by {off[apart].max():.2g} m apart and '
        f'{off.max():.2g} m at most, verdicts by {differ} of {len(few)}'
    )
    rows = (('least', lambda: other.least(few), len(few)),
            ('collision', lambda: other.collisions(states), len(states)))  # fmt: skip
    for want, work, count in rows:
        # Of processor time: one thread each, whatever else the machine does.
        theirs = seconds(work, time.process_time) / count
        mine = seconds(lambda w=want: ask(ours, states, w, 1), time.process_time) / len(states)
        print(
            f'{want}: ours {1e6 * mine:.1f} us, {other.name} {1e6 * theirs:.1f} us, '
            f'ratio {theirs / mine:.1f}',
            flush=True,
        )


def ask(ours: Ours, states: np.ndarray, want: str, threads: int, **how: Any) -> Any:
    """Return the answers of a batch."""
    return evaluate(
        ours.scene_graph, want=want, states=states, joints=ours.joints, threads=threads, **how
    )


def by_threads(ours: Ours, states: np.ndarray) -> None:
    """Print what a second thread gives."""
    for want in ('least', 'collision'):
        one, two = (seconds(lambda n=n, w=want: ask(ours, states, w, n)) for n in (1, 2))
        print(
            f'{want}: two threads are {one / two:.2f} times as fast as one, {len(states)} states'
        )
