"""Pairs of rules in one version of a scene, with the zones that rules alone see."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_geom_ros.geometry import (
    CandidatePairs,
    GeometryId,
    GeometryVersion,
    QueryObject,
    Role,
    SceneGraphInspector,
)
from drake_geom_ros.math.array_types import Flags
from drake_geom_ros.proximity_rules import ProximityRule, ScenePairs, WatchedPairs, Zones


class BoundRules(NamedTuple):
    """The pairs of rules in one version of a scene: slow to make, and without side effects."""

    version: GeometryVersion
    frames_version: int  # -1: of a copy, which has no version among those of the live scene
    rules: tuple[ProximityRule, ...]
    pairs: ScenePairs
    watched: WatchedPairs
    hanging: dict[int, list[int]]
    frames: NDArray[np.int64]  # (n,) by the values of their ids
    bodies: CandidatePairs  # pairs without zones
    zones: Zones
    narrowed: QueryObject

    def is_about(self, version: GeometryVersion) -> bool:
        """Return whether it is about this version of a scene."""
        return is_same_for_rules(self.version, version)

    @property
    def own_narrowed(self) -> QueryObject | None:
        """The query object of its pairs, unless that is of a copy of the scene, with zones."""
        return None if self.watched.needed_zones.any() else self.narrowed

    def is_of(self, version: GeometryVersion, rules: tuple[ProximityRule, ...]) -> bool:
        """Return whether it is about this version of a scene, and these rules."""
        return self.is_about(version) and self.rules == rules


def is_same_for_rules(version: GeometryVersion, other: GeometryVersion) -> bool:
    """Return whether two versions of a scene have the same bodies and zones, which are drawn."""
    return all(version.IsSameAs(other, role) for role in (Role.kProximity, Role.kIllustration))


def narrowed_to(query: QueryObject, watched: WatchedPairs, zones: Zones) -> QueryObject:
    """Return a query object that considers the pairs that rules watch, and no other.

    Where no rule is about any of the ``zones``, the query object has none of them.
    """
    kinds, considered = watched.watched()
    if zones and not watched.needed_zones.any():
        is_body = ~np.isin(watched.ids, [zone.get_value() for zone in zones])
        used, kinds = np.unique(kinds[is_body], return_inverse=True)
        kinds, considered = kinds.ravel(), considered[np.ix_(used, used)]
    return query.narrowed(considered, kinds)


def hanging(
    inspector: SceneGraphInspector, geometries: Sequence[GeometryId]
) -> dict[int, list[int]]:
    """Return by frame the rows of the geometries on it, and on what hangs on it."""
    world = inspector.world_frame_id()
    rows_by_frame: dict[int, list[int]] = defaultdict(list)
    for row, geometry in enumerate(geometries):
        frame = inspector.GetFrameId(geometry)
        while frame != world:
            rows_by_frame[frame.get_value()].append(row)
            frame = inspector.GetParentFrame(frame)
    return dict(rows_by_frame)


class FlagsOnFrames:
    """Flags of the geometries that hang on any of some frames, made once for the same frames.

    Each cycle asks for them, and a robot of 4000 links may wait for its poses meanwhile.
    """

    def __init__(self) -> None:
        self._frames = frozenset[int]()
        self._hanging: Mapping[int, Sequence[int]] | None = None
        self._flags: Flags = np.zeros(0, dtype=np.bool_)

    def of(
        self, frames: Collection[int], hanging: Mapping[int, Sequence[int]], count: int
    ) -> Flags:
        """Return the flags (count,), which nobody can change.

        ``hanging`` are the rows of geometries by frame, and another object where these change.
        """
        if hanging is not self._hanging or frozenset(frames) != self._frames:
            flags = np.zeros(count, dtype=np.bool_)
            if frames:
                flags[[row for frame in frames for row in hanging.get(frame, ())]] = True
            flags.flags.writeable = False
            self._frames, self._hanging, self._flags = frozenset(frames), hanging, flags
        return self._flags
