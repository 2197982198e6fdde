"""Small changes of a pair: of its pose while a scene stands, of its sizes for the next one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bench.searches.hunting import starts
from drake_geom_ros.cross_check.bodies import Body, Pair, as_tuples
from drake_geom_ros.math import RotationMatrix
from drake_geom_ros.math.array_types import Floats
from truth.tolerances import (
    ACCEPTED_SKEW,
    ENTRY_SKEW,
    HUNTED_GAPS,
    HUNTED_LENGTHS,
)

FINEST, COARSEST = -17.0, 0.0  # decades of a step


class Last(NamedTuple):
    """What was last answered about a pair."""

    distance: float
    nhat_BA_W: Floats


def mutated_pose(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Return a pair in another pose: one to three small or structured changes of B."""
    for _ in range(int(rng.integers(1, 4))):
        change = _CHANGES[rng.integers(len(_CHANGES))]
        pair = change(rng, pair, last)
    return Pair(_rotated(pair.a), _rotated(pair.b))


def _rotated(one: Body) -> Body:
    """Return a body whose rotation is one that is accepted."""
    if one.skew < ACCEPTED_SKEW:
        return one
    return one.placed(RotationMatrix.ProjectToRotationMatrix(one.R).matrix(), one.p)


def mutated_size(rng: np.random.Generator, pair: Pair) -> Pair:
    """Return a pair of which one body has another size, or is of another kind."""
    a, b = pair.a, pair.b
    one, other = (a, b) if rng.random() < 0.5 else (b, a)
    if rng.random() < 0.1 and one.kind != 'HalfSpace':
        like = starts.random_pair(rng).a
        changed = replace(one, kind=like.kind, size=like.size)
        if 'HalfSpace' in (like.kind, other.kind):
            changed = one
    else:
        changed = replace(one, size=_changed_size(rng, one, other))
    return Pair(changed if one is a else a, changed if one is b else b)


def _changed_size(rng: np.random.Generator, one: Body, other: Body) -> tuple:
    size = np.array(one.size, dtype=float)
    if not size.size:
        return ()
    match rng.integers(5):
        case 0:
            size *= 2.0 ** rng.integers(-3, 4)
        case 1:
            size *= 10.0 ** rng.normal(size=size.shape[-1:])
        case 2:
            size *= 1.0 + 10.0 ** rng.uniform(FINEST, COARSEST) * rng.normal(size=size.shape)
        case 3 if one.kind == other.kind and one.kind != 'Convex':
            return other.size
        case _:
            size[..., rng.integers(size.shape[-1])] *= 10.0 ** rng.uniform(-2.0, 2.0)
    if one.kind == 'Convex':
        return as_tuples(size)
    return tuple(np.clip(size, *HUNTED_LENGTHS).tolist())


def _step(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Move B along an axis, the normal, the centre line or anyhow."""
    d = pair.b.p - pair.a.p
    along = [pair.a.R[:, rng.integers(3)], pair.b.R[:, rng.integers(3)], last.nhat_BA_W,
             d / (np.linalg.norm(d) or 1.0), rng.normal(size=3)][rng.integers(5)]  # fmt: skip
    length = pair.extent * 10.0 ** rng.uniform(FINEST, COARSEST) * rng.choice([-1.0, 1.0])
    return _with_offset(pair, d + length * along)


def _slide(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Move B along the normal until it is next to touching."""
    gap = pair.extent * rng.choice(HUNTED_GAPS) * rng.choice([-1.0, 1.0])
    return _with_offset(pair, pair.b.p - pair.a.p + (last.distance - gap) * last.nhat_BA_W)


def _snap(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Put B onto an axis, a plane or a lattice, of A, of B or of World."""
    frame = (pair.a.R, pair.b.R, np.eye(3))[rng.integers(3)]
    d = frame.T @ (pair.b.p - pair.a.p)
    match rng.integers(4):
        case 0:
            d[rng.integers(3)] = 0.0
        case 1:
            d[rng.permutation(3)[:2]] = 0.0
        case 2:
            unit = pair.extent * 2.0 ** -float(rng.integers(1, 12))
            d = unit * np.round(d / unit)
        case _:
            d = np.array([float(f'{x:.{rng.integers(1, 4)}g}') for x in d])
    return _with_offset(pair, frame @ d)


def _turn(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Turn B by a small angle, onto A's axes, or anyhow."""
    R = pair.b.R @ starts.tilt(rng) if rng.random() < 0.6 else starts.rotation_beside(rng, pair.a)
    return Pair(pair.a, pair.b.placed(R, pair.b.p))


def _turn_both(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Turn both by the same rotation about World's origin, or A alone."""
    R = starts.rotation(rng)
    if rng.random() < 0.5:
        return Pair(pair.a.placed(R, pair.a.p), pair.b)
    return pair.moved(R, np.zeros(3))


def _place(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Put B to a structured place beside A."""
    return Pair(pair.a, pair.b.at(starts.offset(rng, pair.a, pair.b)))


def _travel(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Bring the pair to World's origin, or far from it."""
    home = _with_offset(Pair(pair.a.at(np.zeros(3)), pair.b), pair.b.p - pair.a.p)
    return home if rng.random() < 0.6 else starts.far(rng, home)


def _skew(rng: np.random.Generator, pair: Pair, last: Last) -> Pair:
    """Take a rotation that is off orthogonal by no more than what is accepted."""
    R = pair.b.R + ENTRY_SKEW * rng.uniform(-1.0, 1.0, (3, 3))
    return Pair(pair.a, pair.b.placed(R, pair.b.p))


def _with_offset(pair: Pair, d: Floats) -> Pair:
    return Pair(pair.a, pair.b.at(pair.a.p + d))


_CHANGES: list[Callable[[np.random.Generator, Pair, Last], Pair]] = [
    *[_step] * 6,
    *[_slide] * 2,
    *[_snap] * 2,
    *[_turn] * 4,
    _turn_both,
    _place,
    _travel,
    _skew,
]
