"""Random pairs without end, most of them awkward: each answer against its own promises.

    python -m bench.fuzz [--pairs 1e5] [--seed 0]

Shapes and poses are those of ``bench.soak``; half of the pairs are then slid along their normal to
within 1e-15 to 1e-2 of touching. What breaks a promise (``evidence.promises``) is made as simple
as it stays broken, and printed as an entry for ``evidence/hard_cases/catalogue``; its ``distance``
is what we answered, the truth is for ``evidence.truth.bodies`` to tell.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bench.soak import BODIES, SCALES
from drake_geom_ros.evidence.asking import PairScene
from drake_geom_ros.evidence.bodies import Body
from drake_geom_ros.evidence.hard_cases.cases import Case, text_of
from drake_geom_ros.evidence.laws import COARSE
from drake_geom_ros.evidence.promises import broken
from drake_geom_ros.evidence.random_bodies import awkward_body, awkward_poses

GAPS = (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2)  # of the scale
DIGITS = (1, 2, 3, 6, 9)
SHOWN = 10  # entries that are printed
ROUNDS = 30  # of making one simpler


def random_pair(rng: np.random.Generator) -> tuple[Body, Body]:
    """Return two bodies at one scale, apart, next to touching or overlapping."""
    scale, lattice = float(rng.choice(SCALES)), bool(rng.random() < 0.4)
    poses = awkward_poses(rng, scale, lattice, BODIES)
    if rng.random() < 0.2:
        poses[1, 3:] = poses[0, 3:]
    a, b = (awkward_body(rng, scale, lattice).posed(X) for X in poses[:2])
    if rng.random() < 0.1:
        a = replace(a, kind='HalfSpace', size=())
    if rng.random() < 0.5:
        row = PairScene(a, b).distance()
        gap = scale * rng.choice(GAPS) * rng.choice([-1.0, 1.0])
        b = b.at(b.p + (row.distance[0] - gap) * row.nhat_BA_W[0])
    return a, b


def simplified(a: Body, b: Body) -> tuple[Body, Body]:
    """Return the pair with plainer numbers that still breaks the first of its promises."""
    wrong = next(promise for promise in broken(a, b) if promise != COARSE)
    for _ in range(ROUNDS):
        for simpler in _simpler(a, b):
            if wrong in broken(*simpler):
                a, b = simpler
                break
        else:
            break
    return a, b


def _simpler(a: Body, b: Body) -> Iterator[tuple[Body, Body]]:
    """Yield simpler pairs, the simplest first: fewer digits, no rotations, fewer vertices."""
    if a.p.any():
        yield a.at(np.zeros(3)), b.at(b.p - a.p)
    for one, other, order in ((a, b, 1), (b, a, -1)):
        for simpler in _simpler_bodies(one):
            yield (simpler, other)[::order]


def _simpler_bodies(one: Body) -> Iterator[Body]:
    if not np.array_equal(one.R, np.eye(3)):
        yield one.placed(np.eye(3), one.p)
    if one.kind == 'Convex' and len(one.size) > 4:
        for k in range(len(one.size)):
            yield replace(one, size=one.size[:k] + one.size[k + 1 :])
    for digits in DIGITS:
        size = tuple(tuple(_short(x, digits) for x in v) if isinstance(v, tuple)
                     else _short(v, digits) for v in one.size)  # fmt: skip
        if size != one.size:
            yield replace(one, size=size)
        p = np.array([_short(x, digits) for x in one.p])
        if not np.array_equal(p, one.p):
            yield one.at(p)


def _short(x: float, digits: int) -> float:
    return float(f'{x:.{digits}g}')


def fuzz(pairs: int, seed: int) -> tuple[Counter[str], list[Case]]:
    """Check so many pairs; return what was broken how often, and the first of them simplified."""
    rng = np.random.default_rng(seed)
    counts, found = Counter[str](), []
    start = time.perf_counter()
    for number in range(pairs):
        a, b = random_pair(rng)
        wrong = broken(a, b)
        counts.update(wrong)
        wrong = [promise for promise in wrong if promise != COARSE]
        if wrong and len(found) < SHOWN:
            a, b = simplified(a, b)
            row = PairScene(a, b).distance()
            about = ', '.join(broken(a, b))
            source = f'bench.fuzz, seed {seed}, pair {number}'
            distance, bound = float(row.distance[0]), float(row.error_bound[0])
            told = {'id': f'fuzz-{seed}-{number}', 'source': source, 'about': about}
            found.append(Case(a, b, distance, bound, **told))
        if number % 1000 == 999:
            took = time.perf_counter() - start
            print(f'\r{number + 1} pairs, {took:.0f} s: {dict(counts)}', end='', flush=True)
    return counts, found


def main() -> None:
    """Fuzz, and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--pairs', type=float, default=1e5, help='how many to check')
    parser.add_argument('--seed', type=int, default=0)
    given = parser.parse_args()
    counts, found = fuzz(int(given.pairs), given.seed)
    print(f'\n{int(given.pairs)} pairs; broken promises: {dict(counts) or "none"}')
    if found:
        print(text_of(found))


if __name__ == '__main__':
    main()
