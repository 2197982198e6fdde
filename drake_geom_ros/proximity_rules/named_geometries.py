"""Geometries that the patterns of a rule's sets match, cached because rules repeat patterns.

Zones are matched by their own names alone: neither by those of their source or frame nor by
wildcards, and no rule of level STOPPABLE is about one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from drake_geom_ros.common.counting import counted
from drake_geom_ros.common.geometry_names import GeometryNames, carrier_names, is_plain, matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import FrameId, GeometryId, SceneGraphInspector
from drake_geom_ros.math.array_types import Flags
from drake_geom_ros.proximity_rules.rule import Level, ProximityRule

_MOST_LOOKED_AT = 5000  # names that are compared with an unknown one


class RuleSets(NamedTuple):
    """Masks (n,) of a rule's two sets, and the names that match nothing."""

    in_a: Flags
    in_b: Flags
    unknown: str = ''  # the first name that matches nothing, if the rule may not lack it
    lacking: tuple[str, ...] = ()


def geometry_names(inspector: SceneGraphInspector, geometry: GeometryId) -> GeometryNames:
    """Return what a geometry is called."""
    frame = inspector.GetFrameId(geometry)
    return GeometryNames(
        inspector.GetOwningSourceName(geometry),
        inspector.GetName(frame),
        inspector.GetName(geometry),
        frame == inspector.world_frame_id(),
        carrier_names(_line(inspector, frame)),
    )


def _line(inspector: SceneGraphInspector, frame: FrameId) -> Iterator[tuple[str, str, bool]]:
    """Yield a frame and those that it hangs on, as ``carrier_names`` takes them."""
    while frame != inspector.world_frame_id():
        source, name = inspector.GetOwningSourceName(frame), inspector.GetName(frame)
        yield source, name, inspector.IsPartOfParent(frame)
        frame = inspector.GetParentFrame(frame)


class NamedGeometries:
    """Geometries (n,) by the names that patterns match."""

    def __init__(self, names: Sequence[GeometryNames], vital: Flags | None = None) -> None:
        """``vital`` (n,) are geometries whose poses rules need although they are in no pair."""
        self.names = names
        self._count = len(names)
        self.vital = np.zeros(self._count, dtype=np.bool_) if vital is None else vital
        self.is_zone: Flags = np.array([each.is_zone for each in names], dtype=np.bool_)
        self._rows: dict[str, list[int]] = {}  # by name; most have one or a few
        for row, names_of_one in enumerate(names):
            found_by = names_of_one.own_names if names_of_one.is_zone else names_of_one.found_by
            for name in dict.fromkeys(found_by):
                self._rows.setdefault(name, []).append(row)
        self._masks: dict[str, Flags] = {}  # by pattern
        self._like: dict[str, str] = {}  # suggestions for patterns that match nothing

    def sets_of(self, rule: ProximityRule, *, may_lack: bool) -> RuleSets:
        """Return the sets of a rule, both empty if a pattern matches nothing.

        A rule that ``may_lack`` patterns goes on with the others if neither set becomes empty.
        """
        may_see = ~self.is_zone if rule.level == Level.STOPPABLE else np.True_
        in_a, in_b = (self._members(names) & may_see for names in (rule.set_a, rule.set_b))
        patterns = (*rule.set_a, *rule.set_b)
        members = [(pattern, self._members([pattern]) & may_see) for pattern in patterns]
        lacking = [pattern for pattern, each in members if not each.any()]
        is_whole = bool(in_a.any()) and (not rule.set_b or bool(in_b.any()))
        if lacking and not (may_lack and is_whole):
            nothing = self._members([])
            return RuleSets(nothing, nothing, lacking[0])
        return RuleSets(
            in_a, in_b if rule.set_b else ~(in_a | self.is_zone), lacking=tuple(lacking)
        )

    def named(self, pattern: str) -> Flags:
        """Return a mask (n,) of the geometries that match a name or pattern, and their zones."""
        members = self._members([pattern])
        for row in np.flatnonzero(self.is_zone).tolist():
            members[row] |= matches(self.names[row].found_by, pattern)
        return members

    def _members(self, patterns: Sequence[str]) -> Flags:
        members = np.zeros(self._count, dtype=np.bool_)
        for pattern in patterns:
            if pattern not in self._masks:
                self._masks[pattern] = self._members_of(pattern)
            members |= self._masks[pattern]
        return members

    def _members_of(self, pattern: str) -> Flags:
        """Return a mask (n,) of the geometries that match a pattern."""
        members = np.zeros(self._count, dtype=np.bool_)
        if is_plain(pattern):
            members[self._rows.get(pattern, [])] = True
            return members
        for name, rows in self._rows.items():
            if matches([name], pattern):
                members[rows] = True
        return members & ~self.is_zone

    def unknown(self, rule: ProximityRule, pattern: str) -> str:
        """Return the error text for a rule with a pattern that matches nothing."""
        if pattern not in self._like:
            self._like[pattern] = nearest(pattern, islice(self._rows, _MOST_LOOKED_AT))
        like = self._like[pattern]
        what = 'queries report'
        if rule.level == Level.STOPPABLE and self._members([pattern]).any():
            like, what = '', f'{what}, but for a zone, which no stoppable rule is about'
        return (
            f'proximity rule {rule.name[:80]!r}: {pattern[:80]!r} stands for no geometry that '
            f'{what}{like}. The scene has {counted(self._count, "geometry")} with '
            'the proximity role; see ~/scene'
        )
