"""Checks of each transform of a message by itself: its names, numbers and stamp."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.live.conversions.misread_numbers import is_misread, why_misread
from drake_geom_ros.live.conversions.transforms import Transforms
from drake_geom_ros.math.array_types import Floats, Indices
from drake_geom_ros.math.batched import are_poses, matrices_from_poses

# [m] longest translation: chains of so many stay within what a scene takes, 2**1004 m.
_FARTHEST = 2.0**900
_SHOWN = 5  # transforms that are named in a refusal


class Refusal(NamedTuple):
    """The number of transforms of a message that were refused, and the reason."""

    transforms: int
    reason: str


def judged(transforms: Transforms) -> tuple[Indices, Refusal]:
    """Return which of the rows of a message are transforms, and what the others are."""
    names, rows = transforms.names, transforms.rows
    good = are_transforms(rows) & names.are_good
    if good.all():
        return np.arange(len(rows)), Refusal(0, '')
    return np.flatnonzero(good), _refusal(names.pairs, rows, np.flatnonzero(~good).tolist())


def are_transforms(rows: Floats) -> NDArray[np.bool_]:
    """Return which rows (n, 7), x y z qx qy qz qw, are taken as transforms (n,)."""
    are_near = (np.abs(rows[:, :3]) <= _FARTHEST).all(axis=1)
    return np.asarray(are_poses(rows) & are_near & ~is_misread(rows).any(axis=1))


def matrices_of(rows: Floats) -> Floats:
    """Return the matrices (n, 4, 4) of transforms (n, 7)."""
    Xs = np.zeros((len(rows), 4, 4))
    Xs[:, :3, :3], Xs[:, :3, 3] = matrices_from_poses(rows)
    Xs[:, 3, 3] = 1.0
    return Xs


def _refusal(names: Sequence[tuple[str, str]], rows: Floats, bad: list[int]) -> Refusal:
    faults = [_fault(*names[k], rows[k]) for k in bad[:_SHOWN]]
    more = f' and {len(bad) - _SHOWN} more' if len(bad) > _SHOWN else ''
    words = f'{len(bad)} of {len(names)} transforms were left out: '
    return Refusal(len(bad), words + '; '.join(faults) + more)


def _fault(parent: str, child: str, row: Floats) -> str:
    """Return what is wrong with a transform, which is none."""
    if not (parent and child and parent != child):
        return f'{child[:80]!r} in {parent[:80]!r}: both names must be given, and must differ'
    try:
        matrices_from_poses(row[np.newaxis])
    except RuntimeError as error:
        return f'{child[:80]!r} in {parent[:80]!r}: {str(error).removeprefix("poses[0]: ")}'
    if (misread := is_misread(row)).any():
        return f'{child[:80]!r} in {parent[:80]!r}: {why_misread(float(row[misread][0]))}'
    return (
        f'the translation of {child[:80]!r} in {parent[:80]!r} has a coordinate beyond '
        f'{_FARTHEST:.3g} m'
    )
