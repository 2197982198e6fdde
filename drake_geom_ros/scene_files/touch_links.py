"""The geometries that an attached frame may touch, by names, patterns and groups of an SRDF."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from drake_geom_ros.common.frame_names import full_name
from drake_geom_ros.common.geometry_names import matches
from drake_geom_ros.common.nearest import nearest
from drake_geom_ros.geometry import (
    ArgumentError,
    CollisionFilterDeclaration,
    FilterId,
    FrameId,
    GeometryId,
    GeometrySet,
    Role,
    SceneGraphInspector,
)
from drake_geom_ros.proximity_rules import geometry_names
from drake_geom_ros.scene_files.description import RobotDescription


class TouchLinks(NamedTuple):
    """The transient filter of an attachment, and the full names of what it may touch."""

    filter_id: FilterId
    names: tuple[str, ...]


def touch_filter(
    inspector: SceneGraphInspector, frame: FrameId, touched: Sequence[GeometryId]
) -> CollisionFilterDeclaration:
    """Return the exclusion of all that a frame carries from the geometries that it may touch."""
    declaration = CollisionFilterDeclaration()
    carried = GeometrySet(frame_ids=carried_frames(inspector, frame))
    declaration.ExcludeBetween(carried, GeometrySet(geometry_ids=touched))
    return declaration


def touched_geometries(
    inspector: SceneGraphInspector,
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
    # Without carriers: a part in the hand that may be touched is another part, which may not.
    named = {
        geometry: geometry_names(inspector, geometry)._replace(carriers=()).found_by
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    }
    touched = set[GeometryId]()
    for pattern in patterns:
        members = {geometry for geometry, own in named.items() if matches(own, pattern)}
        if not members and not _matches_frame(inspector, pattern):
            links = _links_of_group(robots, pattern)
            if links is None:
                raise ArgumentError(_unknown(robots, pattern, named.values()))
            members = set(_on(inspector, links, named))
        touched |= members
    carried = set(carried_frames(inspector, frame))
    return tuple(sorted(g for g in touched if inspector.GetFrameId(g) not in carried))


def full_names(
    inspector: SceneGraphInspector, geometries: Iterable[GeometryId]
) -> tuple[str, ...]:
    """Return the names ``source::frame/geometry`` of geometries, sorted."""
    return tuple(sorted(geometry_names(inspector, geometry).full_name for geometry in geometries))


def carried_frames(inspector: SceneGraphInspector, frame: FrameId) -> list[FrameId]:
    """Return a frame and all frames that hang on it."""
    carried = {frame}
    for each in inspector.FramesParentsFirst():
        if each != inspector.world_frame_id() and inspector.GetParentFrame(each) in carried:
            carried.add(each)
    return sorted(carried)


def _matches_frame(inspector: SceneGraphInspector, pattern: str) -> bool:
    """Return whether a pattern names a frame, which may have no geometry to touch."""
    frames = (f for f in inspector.GetAllFrameIds() if f != inspector.world_frame_id())
    labels = ((inspector.GetOwningSourceName(f), inspector.GetName(f)) for f in frames)
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
