"""Sets of pairs to analyse: those between two name patterns, or all of the scene."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_geom_ros.common.geometry_names import GeometryNames, matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import ArgumentError, FrameId, GeometryId, QueryObject
from drake_geom_ros.live.conversions.names import HEARTBEAT, TRACKED
from drake_geom_ros.live.scene.bound_rules import hanging
from drake_geom_ros.math.array_types import Flags, Indices
from drake_geom_ros.proximity_rules import geometry_names

ALL = 'all'
_BETWEEN = re.compile('(?<!:):(?!:)')  # a colon that is not one of `source::frame`

Between = str | tuple[str, str]


class PairSet(NamedTuple):
    """The name of a set of pairs, and the patterns of its two sides; empty: all pairs."""

    name: str
    side_a: str = ''
    side_b: str = ''


def pair_sets(between: Sequence[Between]) -> tuple[PairSet, ...]:
    """Return the sets of ``'left:right'`` or ``('left', 'right')``; without any, all pairs.

    Raises ArgumentError for other texts, and for a duplicate name.
    """
    sets = []
    for text in between:
        sides = _BETWEEN.split(text) if isinstance(text, str) else list(text)
        if len(sides) != 2 or not all(sides):
            raise ArgumentError(
                f'between={text!r} must be two names or patterns, as left:right; names of '
                'sources, frames (source::frame) or geometries'
            )
        sets.append(PairSet(':'.join(sides), *sides))
    if len({pairs.name for pairs in sets}) < len(sets):
        raise ArgumentError(f'between={list(between)} has two sets of pairs of one name')
    return tuple(sets) or (PairSet(ALL),)


class SelectedPairs(NamedTuple):
    """The pairs of a set in one version of a scene."""

    considered: Flags  # (n, n) symmetric: unfiltered pairs whose geometries have a pose
    left_out: int  # unfiltered pairs with a geometry that has no pose
    needed: tuple[FrameId, ...]  # frames whose poses the considered pairs use
    waiting: tuple[FrameId, ...]  # frames without a pose, of pairs left out


def selected_pairs(
    query: QueryObject, pairs: PairSet, *, may_be_empty: bool = False
) -> SelectedPairs:
    """Return the pairs of a set in a scene.

    Raises ArgumentError if there are none, unless the set ``may_be_empty``: an attachment excludes
    pairs for a while, and tracked bodies come and go.
    """
    inspector = query.inspector()
    ids, reported = inspector.candidate_matrix()
    geometries = [GeometryId(value) for value in ids.tolist()]
    names = [geometry_names(inspector, geometry) for geometry in geometries]
    between = _between(pairs, names, may_lack=may_be_empty)
    selected = reported & between
    if not may_be_empty:
        _check_any(pairs, selected)
    placed = np.array([query.is_placed(geometry) for geometry in geometries], dtype=np.bool_)
    both = placed[:, None] & placed[None, :]
    considered, waiting = selected & both, np.asarray((selected & ~both).any(axis=1))
    on = hanging(inspector, geometries)
    # The heartbeat of trackers is in no pair, but without it nobody knows which bodies are there.
    beats = np.array([(n.source, n.frame_name) == (TRACKED, HEARTBEAT) for n in names], dtype=bool)
    beats &= between.any(axis=1)
    waiting |= beats & ~placed
    rows = np.asarray(considered.any(axis=1)) | (beats & placed)
    return SelectedPairs(
        considered=considered,
        left_out=int(np.count_nonzero(selected & ~both)) // 2 + int((beats & ~placed).sum()),
        needed=tuple(FrameId(frame) for frame, some in on.items() if rows[some].any()),
        waiting=tuple(
            f for f in query.waiting_frames() if waiting[on.get(f.get_value(), [])].any()
        ),
    )


def reported_pairs(query: QueryObject, sets: Sequence[PairSet]) -> tuple[Indices, Flags]:
    """Return the id values (n,) of a scene's geometries, and (n, n) their pairs of any set.

    These are the unfiltered ones, whether or not their geometries have a pose. A set without any
    raises ArgumentError.
    """
    inspector = query.inspector()
    ids, reported = inspector.candidate_matrix()
    names = [geometry_names(inspector, GeometryId(value)) for value in ids.tolist()]
    of_any = np.zeros_like(reported)
    for pairs in sets:
        selected = reported & _between(pairs, names, may_lack=False)
        _check_any(pairs, selected)
        of_any |= selected
    return ids, of_any


def _check_any(pairs: PairSet, selected: Flags) -> None:
    if not selected.any():
        raise ArgumentError(
            f'between {pairs.name}: the scene has no pair that queries report: all are filtered, '
            'of one frame, or of two anchored geometries'
        )


def _between(pairs: PairSet, names: Sequence[GeometryNames], *, may_lack: bool) -> Flags:
    """Return a mask (n, n) of the pairs with one geometry on each side.

    Raises ArgumentError for a side that matches nothing, unless names ``may_lack``.
    """
    if not pairs.side_a:
        return np.ones((len(names), len(names)), dtype=np.bool_)
    in_a, in_b = (_members(pattern, names) for pattern in pairs[1:])
    for pattern, members in ((pairs.side_a, in_a), (pairs.side_b, in_b)):
        if not (may_lack or members.any()):
            raise ArgumentError(_unknown(pattern, names, pairs.name))
    one_way = in_a[:, None] & in_b[None, :]
    return np.asarray(one_way | one_way.T)


def _members(pattern: str, names: Sequence[GeometryNames]) -> Flags:
    """Return a mask (n,) of the geometries that match a pattern."""
    return np.array([matches(each.found_by, pattern) for each in names], dtype=np.bool_)


def _unknown(pattern: str, names: Sequence[GeometryNames], of: str) -> str:
    every_name = dict.fromkeys(name for each in names for name in each.found_by)
    return (
        f'between {of}: {pattern!r} stands for no geometry with the proximity role'
        f'{nearest(pattern, every_name)}; there are '
        f'{", ".join(list(every_name)[:10]) or "none"}'
    )
