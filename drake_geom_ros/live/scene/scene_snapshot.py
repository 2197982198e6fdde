"""The live scene as it was at one moment, to be described while nobody holds it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from drake_geom_ros.geometry import (
    CandidatePairs,
    FilterId,
    FrameId,
    QueryObject,
    Role,
    SceneGraph,
    SceneGraphContext,
    SourceId,
)
from drake_geom_ros.live.conversions.names import MAPS, TRACKED
from drake_geom_ros.proximity_rules import ProximityRule
from drake_geom_ros.scene_files import (
    AwaitedFilter,
    CameraDescription,
    FrameDescription,
    Gate,
    ObstacleSource,
    RobotDescription,
    SceneDescription,
    describe,
    poses_in_parents,
    without_source,
)


@dataclass(frozen=True)
class SnapshotMark:
    """The mark of a description: a later scene with the same mark has the same description.

    Poses, values of joints and the cells of sensed maps are not in it.
    """

    version: int
    pairs: CandidatePairs
    transient_filters: tuple[FilterId, ...]
    cameras: Mapping[str, tuple[FrameId, CameraDescription]]
    awaited: tuple[AwaitedFilter, ...]

    def matches(self, other: SnapshotMark) -> bool:
        """Return whether another mark is of the same scene."""
        names = ('version', 'transient_filters', 'cameras', 'awaited')
        is_same = all(getattr(self, name) == getattr(other, name) for name in names)
        return is_same and self.pairs.matches(other.pairs)


@dataclass(frozen=True)
class SceneSnapshot:
    """A copy of the scene with what is described beside its content."""

    context: SceneGraphContext
    mark: SnapshotMark
    robots: tuple[RobotDescription, ...]  # as joint values have them stand
    is_static: Mapping[int, bool]  # by the values of frames' ids
    waiting: tuple[AwaitedFilter, ...]
    rules: tuple[ProximityRule, ...]
    maps: SourceId | None
    obstacle_sources: tuple[ObstacleSource, ...] = ()
    gates: tuple[Gate, ...] = ()
    has_tracked: bool = False  # the source of tracked bodies is there
    # Geometries that attached frames may touch until they are detached, by full names.
    touch_links: Mapping[FrameId, tuple[str, ...]] = field(default_factory=dict)
    # Seconds after which frames leave, by the values of their ids.
    gone_after: Mapping[int, float] = field(default_factory=dict)

    def description(self) -> SceneDescription:
        """Return the scene: persistent filters included, every frame where it was.

        Frames that wait for their first pose go on waiting in it. Sensed maps and tracked bodies
        are left out.
        """
        query = QueryObject(self.context)
        frames = query.inspector().GetAllFrameIds()
        static = {f: self.is_static[v] for f in frames if (v := f.get_value()) in self.is_static}
        poses, cameras = poses_in_parents(query), self.mark.cameras.values()
        described = describe(
            SceneGraph(), poses, self.robots, static, cameras, context=self.context
        )
        if self.maps is not None:  # what was seen is no model of anything
            described = without_source(described, MAPS)
        if self.has_tracked:  # they come and go with their tracker
            described = without_source(described, TRACKED)
        described = replace(described, frames=tuple(self._frames(described)))
        return replace(
            described,
            awaited=self.waiting,
            rules=self.rules,
            obstacle_sources=self.obstacle_sources,
            gates=self.gates,
        )

    def _frames(self, described: SceneDescription) -> Iterator[FrameDescription]:
        """Yield the frames, with what they may touch, and when they leave."""
        inspector = QueryObject(self.context).inspector()

        def label(frame: FrameId) -> tuple[str, str]:
            return inspector.GetOwningSourceName(frame), inspector.GetName(frame)

        touch_links = {label(frame): names for frame, names in self.touch_links.items()}
        gone_after = {label(FrameId(value)): s for value, s in self.gone_after.items()}
        there = {
            f'{g.source}::{g.frame}/{g.name}'
            for g in described.geometries
            if Role.kProximity in g.roles
        }
        for frame in described.frames:
            names = touch_links.get((frame.source, frame.name), ())
            seconds = gone_after.get((frame.source, frame.name))
            if seconds is not None:  # it is not where it was
                frame = replace(frame, X_PF=None, static=None, gone_after=seconds)
            yield replace(frame, touch_links=tuple(n for n in names if n in there))
