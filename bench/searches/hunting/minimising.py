"""What was found, made as simple as it stays broken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from bench.searches.hunting.asking import Scenes, merged
from bench.searches.hunting.starts import valid
from drake_geom_ros.cross_check.bodies import Body, Pair
from drake_geom_ros.math.array_types import Floats
from truth.tolerances import ROUNDED_SKEW

DIGITS = (1, 2, 3, 6, 9)
ROUNDS = 30
KEPT = 0.5  # part of the ratio that a simpler pair must keep


def minimised(pair: Pair, law: str, seed: int = 0) -> tuple[Pair, float]:
    """Return a pair of plainer numbers that breaks a law still, and its ratio.

    A ratio of 1 or less says that the law was broken by what was asked before, or on a chain.
    """
    (ratio,) = ratios([pair], law, seed)
    for _ in range(ROUNDS if ratio > 1.0 else 0):
        simpler = [each for each in _simpler(pair) if valid(each)]
        found = ratios(simpler, law, seed) if simpler else np.zeros(0)
        as_bad = np.flatnonzero(found > max(1.0, KEPT * min(ratio, 10.0)))
        if not len(as_bad):
            break
        pair, ratio = simpler[as_bad[0]], found[as_bad[0]]
    return pair, float(ratio)


def ratios(pairs: Sequence[Pair], law: str, seed: int) -> Floats:
    """Return how badly pairs break a law, each asked for the first time."""
    scenes = Scenes(pairs, np.random.default_rng(seed), chains=False)
    worst: Floats = merged(scenes.ask(pairs, np.zeros((len(pairs), 3))))[law]
    return worst


def _simpler(pair: Pair) -> Iterator[Pair]:
    """Yield simpler pairs, the simplest first: fewer digits, no rotations, fewer vertices."""
    a, b = pair.a, pair.b
    if a.p.any():
        yield Pair(a.at(np.zeros(3)), b.at(b.p - a.p))
    if not np.array_equal(a.R, np.eye(3)):
        yield pair.moved(a.R.T, np.zeros(3))
    for simpler in _simpler_bodies(a):
        yield Pair(simpler, b)
    for simpler in _simpler_bodies(b):
        yield Pair(a, simpler)


def _simpler_bodies(one: Body) -> Iterator[Body]:
    if not np.array_equal(one.R, np.eye(3)):
        yield one.placed(np.eye(3), one.p)
        simpler = one.placed(np.round(one.R, 2), one.p)
        if simpler.skew < ROUNDED_SKEW and (simpler.R != one.R).any():
            yield simpler
    if one.kind == 'Convex' and len(one.size) > 4:
        for k in range(len(one.size)):
            yield replace(one, size=one.size[:k] + one.size[k + 1 :])
    for digits in DIGITS:
        size = tuple(
            tuple(_short(x, digits) for x in v) if isinstance(v, tuple) else _short(v, digits)
            for v in one.size
        )
        if size != one.size:
            yield replace(one, size=size)
        p = np.array([_short(x, digits) for x in one.p])
        if not np.array_equal(p, one.p):
            yield one.at(p)


def _short(x: float, digits: int) -> float:
    return float(f'{x:.{digits}g}')
