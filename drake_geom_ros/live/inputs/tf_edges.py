"""TransformStamped messages to edges of the tree of TF, each checked for itself."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.live.conversions.fields import seconds_of
from drake_geom_ros.live.conversions.misread_numbers import is_misread, why_misread
from drake_geom_ros.live.scene.clocks import ALWAYS, Arrival, Since
from drake_geom_ros.math.array_types import Floats
from drake_geom_ros.math.batched import are_poses, matrices_from_poses

# [m] longest translation: chains of so many stay within what a scene takes, 2**1004 m.
_FARTHEST = 2.0**900
_SHOWN = 5  # transforms that are named in a refusal


class Edge(NamedTuple):
    """The newest transform of a TF frame C in its parent P."""

    parent: str
    X_PC: Floats  # (4, 4)
    stamp: float  # [s] of the message; inf for a static one
    since: Since

    @property
    def R_PC(self) -> Floats:
        """The rotation (3, 3)."""
        return self.X_PC[:3, :3]

    @property
    def p_PC(self) -> Floats:
        """The translation (3,) [m]."""
        return self.X_PC[:3, 3]


class Refusal(NamedTuple):
    """The number of transforms of a message that were refused, and the reason."""

    transforms: int
    reason: str


def read_edges(
    transforms: Sequence[Any], arrival: Arrival, *, static: bool
) -> tuple[list[tuple[str, Edge]], Refusal]:
    """Return the child's name and edge of each transform that is one, and what the others are."""
    names, numbers = names_in(transforms), []
    for entry in transforms:
        p, q = entry.transform.translation, entry.transform.rotation
        numbers.append((p.x, p.y, p.z, q.x, q.y, q.z, q.w))
    stamps = [math.inf if static else seconds_of(entry.header.stamp) for entry in transforms]
    rows = np.array(numbers, dtype=np.float64).reshape(-1, 7)
    good = are_transforms(rows) & np.array([_are_names(*both) for both in names], dtype=bool)
    since = {s: ALWAYS if static else arrival.since(s) for s in set(stamps)}
    good_rows = np.flatnonzero(good).tolist()
    edges = [
        (names[k][1], Edge(names[k][0], X_PC, stamps[k], since[stamps[k]]))
        for k, X_PC in zip(good_rows, matrices_of(rows[good_rows]), strict=True)
    ]
    return edges, _refusal(names, rows, np.flatnonzero(~good).tolist())


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


def names_in(transforms: Sequence[Any]) -> list[tuple[str, str]]:
    """Return the names of the parent and the child of each transform."""
    return [
        (plain_name(entry.header.frame_id), plain_name(entry.child_frame_id))
        for entry in transforms
    ]


def plain_name(name: str) -> str:
    """Return a TF frame's name without the leading slash that TF once had."""
    return name.removeprefix('/')


def _are_names(parent: str, child: str) -> bool:
    return bool(parent and child and parent != child)


def _refusal(names: Sequence[tuple[str, str]], rows: Floats, bad: list[int]) -> Refusal:
    if not bad:
        return Refusal(0, '')
    faults = [_fault(*names[k], rows[k]) for k in bad[:_SHOWN]]
    more = f' and {len(bad) - _SHOWN} more' if len(bad) > _SHOWN else ''
    words = f'{len(bad)} of {len(names)} transforms were left out: '
    return Refusal(len(bad), words + '; '.join(faults) + more)


def _fault(parent: str, child: str, row: Floats) -> str:
    """Return what is wrong with a transform, which is none."""
    if not _are_names(parent, child):
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
