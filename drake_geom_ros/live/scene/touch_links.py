"""The geometries that an attached frame may touch: their names, and the filters of attachments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from drake_geom_ros.common.frame_names import full_name
from drake_geom_ros.common.geometry_names import matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import (
    ArgumentError,
    FilterId,
    FrameId,
    GeometryId,
    Role,
    SceneGraphInspector,
)
from drake_geom_ros.live.conversions.names import NameTable
from drake_geom_ros.live.scene.scene_model import SceneModel
from drake_geom_ros.live.scene.scene_rules import geometry_names
from drake_geom_ros.scene_files import RobotDescription


class TouchLinks(NamedTuple):
    """The transient filter of an attachment, and the full names of what it may touch."""

    filter_id: FilterId
    names: tuple[str, ...]


class AttachmentFilters:
    """The filters of attached frames that may touch something."""

    def __init__(self, model: SceneModel) -> None:
        self._model = model
        self._by_frame: dict[FrameId, TouchLinks] = {}

    def begin(self, frame: FrameId, touch_links: TouchLinks) -> None:
        """Keep the filter of an attachment."""
        self._by_frame[frame] = touch_links

    def end(self, frame: FrameId) -> None:
        """Forget the filter of a frame, which was removed or never was."""
        self._by_frame.pop(frame, None)

    def forget(self, frames: Iterable[FrameId]) -> list[FilterId]:
        """Remove the filters of frames that have gone; return those that were active."""
        gone = [self._by_frame.pop(frame) for frame in frames if frame in self._by_frame]
        return self._model.filter_manager.RemoveDeclarations(each.filter_id for each in gone)

    def filter_of(self, frame: FrameId) -> FilterId | None:
        """Return the filter of an attached frame; None: it has none, or it ended."""
        touch_links = self._by_frame.get(frame)
        if touch_links is None or not self._model.filter_manager.IsActive(touch_links.filter_id):
            return None
        return touch_links.filter_id

    def names(self) -> Mapping[FrameId, tuple[str, ...]]:
        """Return what each frame whose filter is active may touch, by full names."""
        return {
            frame: each.names for frame, each in self._by_frame.items() if self.filter_of(frame)
        }


def touched_geometries(
    inspector: SceneGraphInspector,
    names: NameTable,
    robots: Sequence[RobotDescription],
    frame: FrameId,
    patterns: Sequence[str],
) -> tuple[GeometryId, ...]:
    """Return the geometries that ``patterns`` name, without those that ``frame`` carries.

    A pattern may hold ``*`` and ``?``. It matches the names of sources, frames and geometries,
    with or without their source; what a frame carries is not included. Where it matches none, it
    may be a group of a robot's SRDF, ``group`` or ``robot::group``. Raises ArgumentError for one
    that stands for nothing.
    """
    if not patterns:
        return ()  # it takes a look at each geometry to find what names stand for
    named = {
        geometry: geometry_names(inspector, geometry)._replace(carriers=()).found_by
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    }
    touched = set[GeometryId]()
    for pattern in patterns:
        members = {geometry for geometry, own in named.items() if matches(own, pattern)}
        if not members and not _matches_frame(names, pattern):
            links = _links_of_group(robots, pattern)
            if links is None:
                raise ArgumentError(_unknown(robots, pattern, named.values()))
            members = set(_on(inspector, links, named))
        touched |= members
    carried = set(carried_frames(inspector, frame))
    return tuple(sorted(g for g in touched if inspector.GetFrameId(g) not in carried))


def carried_frames(inspector: SceneGraphInspector, frame: FrameId) -> list[FrameId]:
    """Return a frame and all frames that hang on it."""
    carried = {frame}
    for each in inspector.FramesParentsFirst():
        if each != inspector.world_frame_id() and inspector.GetParentFrame(each) in carried:
            carried.add(each)
    return sorted(carried)


def _matches_frame(names: NameTable, pattern: str) -> bool:
    """Return whether a pattern names a frame, which may have no geometry to touch."""
    labels = names.labels.values()
    return any(matches((name, full_name((source, name))), pattern) for source, name in labels)


def _links_of_group(robots: Iterable[RobotDescription], name: str) -> set[tuple[str, str]] | None:
    """Return the links of a group by robot and name; None: there is no such group.

    Raises ArgumentError where several robots have the group.
    """
    groups = [
        (robot.name, links)
        for robot in robots
        for group, links in robot.groups.items()
        if name in (group, full_name((robot.name, group)))
    ]
    if len(groups) > 1:
        whole = ', '.join(repr(full_name((robot, name))) for robot, _ in groups)
        raise ArgumentError(f'touch_links: {name[:80]!r} is a group of several robots: {whole}')
    return {(robot, link) for robot, links in groups for link in links} if groups else None


def _on(
    inspector: SceneGraphInspector,
    links: set[tuple[str, str]],
    geometries: Iterable[GeometryId],
) -> Iterator[GeometryId]:
    for geometry in geometries:
        frame = inspector.GetFrameId(geometry)
        if (inspector.GetOwningSourceName(geometry), inspector.GetName(frame)) in links:
            yield geometry


def _unknown(
    robots: Sequence[RobotDescription], pattern: str, named: Iterable[tuple[str, ...]]
) -> str:
    groups = [group for robot in robots for group in robot.groups]
    every_name = [*dict.fromkeys(name for names in named for name in names), *groups]
    return (
        f'touch_links: {pattern[:80]!r} stands for no frame, no geometry and no group of an SRDF'
        f'{nearest(pattern, every_name)}; see the topic ~/scene'
    )
