"""States and edges a second of two arms, by all libraries that are installed, in one run.

    ./run exec python -m bench.batches.race [--states 2000] [--edges 200] [--add FOLDER ...]

The scene and filters are those of ``bench.batches``: random joint values, edges of 0.5 rad that
start free. Processor time of one thread, the least of three turns. ``--add`` are folders of
libraries that nothing else here needs, by ``uv pip install --no-deps --target FOLDER
tesseract-robotics==0.5.1`` or ``mujoco-warp==4.0.0 warp-lang==1.19.0``. Tesseract knows no
ellipsoids: its edges are checked without these.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from bench.batches.ours import Ours
from bench.batches.timing import TURNS, ask, sides
from bench.motion.arms import edges_of, lengths
from drake_geom_ros.batch import Checker, PathChecker

RESOLUTION = 0.002  # [m] of the fastest link, of edges that are checked at states

Way = tuple[str, str, int, Callable[[], Any]]  # library, what is counted, how many, the call


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--states', type=int, default=2000)
    parser.add_argument('--edges', type=int, default=200)
    parser.add_argument('--add', nargs='*', default=[])
    options = parser.parse_args()
    sys.path[:0] = options.add
    ours = Ours()
    others = sides(ours)
    try:
        from bench.batches.warp_side import WarpSide

        others.append(WarpSide(ours))
    except ImportError as error:
        print(f'not installed here, left out: MuJoCo Warp ({error})')
    states = ours.states(options.states)
    checker = Checker(ours.scene_graph, ours.joints)
    paths = edges_of(checker, ours.joints, options.edges, 0.5)
    ways = [*_of_states(ours, others, states), *_of_edges(ours, others, paths)]
    print(f'{"library":48}{"what":10}{"a second":>12}{"ours / its":>12}')
    best: dict[str, float] = {}
    for name, what, count, call in ways:
        call()  # compiles
        rate = count / min(_seconds(call) for _ in range(TURNS))
        best.setdefault(what, rate)
        print(f'{name:48}{what:10}{rate:12.0f}{best[what] / rate:12.1f}', flush=True)


def _seconds(call: Callable[[], Any]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start


def _of_states(ours: Ours, others: list[Any], states: np.ndarray) -> Iterator[Way]:
    """Yield the ways to decide whether states collide, ours first."""
    count = len(states)
    yield 'ours, evaluate', 'states', count, lambda: ask(ours, states, 'collision', 1)
    free = Checker(ours.scene_graph, ours.joints)
    yield 'ours, Checker.free_each', 'states', count, lambda: free.free_each(states)
    expected = ask(ours, states[:200], 'collision', 1)
    for side in others:
        differ = int((side.collisions(states[:200]) != expected).sum())
        name = f'{side.name} ({differ} of 200 verdicts differ)'
        yield name, 'states', count, lambda side=side: side.collisions(states)


def _of_edges(ours: Ours, others: list[Any], paths: np.ndarray) -> Iterator[Way]:
    """Yield the ways to decide whether edges are free, ours first."""
    count, proofs = len(paths), PathChecker(ours.scene_graph, ours.joints)
    yield 'ours, PathChecker: proved', 'edges', count, lambda: [proofs.check(p) for p in paths]
    steps = np.maximum(1, np.ceil(lengths(ours.joints, paths) / RESOLUTION).astype(int)).tolist()
    for side in others:
        if hasattr(side, 'edge_is_free'):
            name = f'{side.name}, every {1000 * RESOLUTION:.0f} mm'
            pairs = list(zip(paths, steps, strict=True))
            yield (
                name,
                'edges',
                count,
                lambda side=side, pairs=pairs: [side.edge_is_free(*pair) for pair in pairs],
            )
    try:
        from bench.motion.tesseract_side import TesseractArms
    except ImportError as error:
        print(f'not installed here, left out: tesseract ({error})')
        return
    fewer = Ours()
    arms = TesseractArms(fewer)
    alone = PathChecker(fewer.scene_graph, fewer.joints)
    yield (
        'ours, proved, without ellipsoids',
        'edges',
        count,
        lambda: [alone.check(p) for p in paths],
    )
    for segments in (1, 10):
        cast = [arms.states(path, segments) for path in paths]
        yield (
            f'tesseract, {segments} casts, without ellipsoids',
            'edges',
            count,
            lambda cast=cast: [arms.manager.is_free(one) for one in cast],
        )


if __name__ == '__main__':
    main()
