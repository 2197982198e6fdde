"""Small changes of a pair: of its pose while a scene stands, of its sizes for the next one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from bench.hard_cases.cases import Body, Case, Floats
from bench.hunt import starts
from drake_geom_ros.math import RotationMatrix

GAPS = (0.0, 1e-16, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2)  # of the extent
FINEST, COARSEST = -17.0, 0.0  # decades of a step
LENGTHS = 1e-9, 1e5  # [m] that sizes stay between
SKEW = 1e-13  # [-] that a valid rotation may be off orthogonal by in each number


class Last(NamedTuple):
    """What was last answered about a pair."""

    distance: float
    nhat_BA_W: Floats


def mutated_pose(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Return a pair in another pose: one to three small or structured changes of B."""
    for _ in range(int(rng.integers(1, 4))):
        change = _CHANGES[rng.integers(len(_CHANGES))]
        case = change(rng, case, last)
    return replace(case, a=_rotated(case.a), b=_rotated(case.b))


def _rotated(one: Body) -> Body:
    """Return a body whose rotation is one that is accepted."""
    if starts.skew(one) < starts.ACCEPTED:
        return one
    return replace(one, R=RotationMatrix.ProjectToRotationMatrix(one.R).matrix())


def mutated_size(rng: np.random.Generator, case: Case) -> Case:
    """Return a pair of which one body has another size, or is of another kind."""
    a, b = case.a, case.b
    one, other = (a, b) if rng.random() < 0.5 else (b, a)
    if rng.random() < 0.1 and one.kind != 'HalfSpace':
        like = starts.random_pair(rng).a
        changed = replace(one, kind=like.kind, size=like.size)
        if 'HalfSpace' in (like.kind, other.kind):
            changed = one
    else:
        changed = replace(one, size=_changed_size(rng, one, other))
    return replace(case, a=changed if one is a else a, b=changed if one is b else b)


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
        return tuple(map(tuple, size.tolist()))
    return tuple(np.clip(size, *LENGTHS).tolist())


def _step(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Move B along an axis, the normal, the centre line or anyhow."""
    d = case.b.p - case.a.p
    along = [case.a.R[:, rng.integers(3)], case.b.R[:, rng.integers(3)], last.nhat_BA_W,
             d / (np.linalg.norm(d) or 1.0), rng.normal(size=3)][rng.integers(5)]  # fmt: skip
    length = case.extent * 10.0 ** rng.uniform(FINEST, COARSEST) * rng.choice([-1.0, 1.0])
    return _with_offset(case, d + length * along)


def _slide(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Move B along the normal until it is next to touching."""
    gap = case.extent * rng.choice(GAPS) * rng.choice([-1.0, 1.0])
    return _with_offset(case, case.b.p - case.a.p + (last.distance - gap) * last.nhat_BA_W)


def _snap(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Put B onto an axis, a plane or a lattice, of A, of B or of World."""
    frame = (case.a.R, case.b.R, np.eye(3))[rng.integers(3)]
    d = frame.T @ (case.b.p - case.a.p)
    match rng.integers(4):
        case 0:
            d[rng.integers(3)] = 0.0
        case 1:
            d[rng.permutation(3)[:2]] = 0.0
        case 2:
            unit = case.extent * 2.0 ** -float(rng.integers(1, 12))
            d = unit * np.round(d / unit)
        case _:
            d = np.array([float(f'{x:.{rng.integers(1, 4)}g}') for x in d])
    return _with_offset(case, frame @ d)


def _turn(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Turn B by a small angle, onto A's axes, or anyhow."""
    R = case.b.R @ starts.tilt(rng) if rng.random() < 0.6 else starts.rotation_beside(rng, case.a)
    return replace(case, b=replace(case.b, R=R))


def _turn_both(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Turn both by the same rotation about World's origin, or A alone."""
    R = starts.rotation(rng)
    if rng.random() < 0.5:
        return replace(case, a=replace(case.a, R=R))
    return replace(case, a=case.a.moved(R, np.zeros(3)), b=case.b.moved(R, np.zeros(3)))


def _place(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Put B to a structured place beside A."""
    return replace(case, b=replace(case.b, p=starts.offset(rng, case.a, case.b)))


def _travel(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Bring the pair to World's origin, or far from it."""
    home = _with_offset(replace(case, a=replace(case.a, p=np.zeros(3))), case.b.p - case.a.p)
    return home if rng.random() < 0.6 else starts.far(rng, home)


def _skew(rng: np.random.Generator, case: Case, last: Last) -> Case:
    """Take a rotation that is off orthogonal by no more than what is accepted."""
    R = case.b.R + SKEW * rng.uniform(-1.0, 1.0, (3, 3))
    return replace(case, b=replace(case.b, R=R))


def _with_offset(case: Case, d: Floats) -> Case:
    return replace(case, b=replace(case.b, p=case.a.p + d))


_CHANGES: list[Callable[[np.random.Generator, Case, Last], Case]] = [
    *[_step] * 6,
    *[_slide] * 2,
    *[_snap] * 2,
    *[_turn] * 4,
    _turn_both,
    _place,
    _travel,
    _skew,
]
