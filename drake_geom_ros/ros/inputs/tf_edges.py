"""TransformStamped messages to edges of the tree of TF, each checked for itself. No ROS import."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.math.batched import are_poses, matrices_from_poses
from drake_geom_ros.ros.conversions.fields import seconds_of
from drake_geom_ros.ros.scene.clocks import ALWAYS, Arrival, Since

# [m] longest translation: chains of so many stay within what a scene takes, 2**1004 m.
_FARTHEST = 2.0**900
_SHOWN = 5  # transforms that are named in a refusal

Floats = NDArray[np.float64]


class Edge(NamedTuple):
    """The newest transform of a TF frame C in its parent P."""

    parent: str
    R_PC: Floats
    p_PC: Floats  # [m]
    stamp: float  # [s] of the message; inf for a static one
    since: Since


class Refusal(NamedTuple):
    """How many transforms of a message were not taken, and why."""

    transforms: int
    reason: str


def read_edges(
    transforms: Sequence[Any], arrival: Arrival, *, static: bool
) -> tuple[list[tuple[str, Edge]], Refusal]:
    """Return the child's name and edge of each transform that is one, and what the others are."""
    rows = np.zeros((len(transforms), 7))
    for row, entry in zip(rows, transforms, strict=True):
        p, q = entry.transform.translation, entry.transform.rotation
        row[:] = p.x, p.y, p.z, q.x, q.y, q.z, q.w
    good = are_poses(rows) & (np.abs(rows[:, :3]) <= _FARTHEST).all(axis=1)
    good &= np.array([_are_names(*_names(entry)) for entry in transforms], dtype=bool)
    kept = np.flatnonzero(good).tolist()
    edges = []
    for k, R_PC, p_PC in zip(kept, *matrices_from_poses(rows[kept]), strict=True):
        parent, child = _names(transforms[k])
        stamp, since = math.inf, ALWAYS
        if not static:
            stamp = seconds_of(transforms[k].header.stamp)
            since = arrival.since(stamp)
        edges.append((child, Edge(parent, R_PC, p_PC, stamp, since)))
    return edges, _refusal(transforms, rows, np.flatnonzero(~good).tolist())


def plain_name(name: str) -> str:
    """Return a TF frame's name without the leading slash that TF once had."""
    return name.removeprefix('/')


def _names(entry: Any) -> tuple[str, str]:
    """Return the names of the parent and the child."""
    return plain_name(entry.header.frame_id), plain_name(entry.child_frame_id)


def _are_names(parent: str, child: str) -> bool:
    return bool(parent and child and parent != child)


def _refusal(transforms: Sequence[Any], rows: Floats, bad: list[int]) -> Refusal:
    if not bad:
        return Refusal(0, '')
    told = [_fault(*_names(transforms[k]), rows[k]) for k in bad[:_SHOWN]]
    more = f' and {len(bad) - _SHOWN} more' if len(bad) > _SHOWN else ''
    words = f'{len(bad)} of {len(transforms)} transforms were left out: '
    return Refusal(len(bad), words + '; '.join(told) + more)


def _fault(parent: str, child: str, row: Floats) -> str:
    """Return what is wrong with a transform, which is none."""
    if not _are_names(parent, child):
        return f'{child[:80]!r} in {parent[:80]!r}: both names must be given, and must differ'
    try:
        matrices_from_poses(row[np.newaxis])
    except RuntimeError as error:
        return f'{child[:80]!r} in {parent[:80]!r}: {str(error).removeprefix("poses[0]: ")}'
    return (
        f'the translation of {child[:80]!r} in {parent[:80]!r} has a coordinate beyond '
        f'{_FARTHEST:.3g} m'
    )
