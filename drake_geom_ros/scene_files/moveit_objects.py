"""Bodies of a scene as the objects of MoveIt's world: those of robots are left out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

from drake_geom_ros.geometry import (
    FrameId,
    GeometryId,
    QueryObject,
    Role,
    SceneGraphInspector,
)
from drake_geom_ros.math import RigidTransform


class MoveItObject(NamedTuple):
    """An object O: its full name, its pose in the frame that carries it, and frames on it.

    ``link`` is the link of a robot that carries it, None for the world; ``frame`` is its own,
    None of an anchored geometry.
    """

    name: str
    X_PO: RigidTransform
    geometries: list[GeometryId]
    subframes: dict[str, RigidTransform]
    link: FrameId | None = None
    frame: FrameId | None = None


class MoveItObjects(NamedTuple):
    """The objects of a scene.

    ``of_robots`` counts the geometries of robots, and ``waiting`` are the frames with geometries
    that never had a pose: these are in no object.
    """

    objects: list[MoveItObject]
    of_robots: int
    waiting: list[FrameId]


def moveit_objects(
    query: QueryObject,
    robots: Collection[str],
    name_of: Callable[[FrameId | GeometryId], str],
) -> MoveItObjects:
    """Return the bodies of a scene beside those of ``robots``, which are names of sources.

    A frame with geometries becomes an object, an anchored geometry one of its own. ``name_of``
    returns full names. A frame on another one with geometries is an object of its own; one
    without any is a subframe.
    """
    inspector = query.inspector()
    world, by_frame, of_robots = inspector.world_frame_id(), dict[FrameId, list[GeometryId]](), 0
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        frame = inspector.GetFrameId(geometry)
        if frame != world and _owner(inspector, frame) in robots:
            of_robots += 1
        else:
            by_frame.setdefault(frame, []).append(geometry)
    objects, waiting = list[MoveItObject](), list[FrameId]()
    for frame, geometries in by_frame.items():
        if frame == world:
            here = RigidTransform()
            objects += [MoveItObject(name_of(g), here, [g], {}) for g in geometries]
        elif not query.is_placed(frame):
            waiting.append(frame)
        else:
            link = _carrier(inspector, frame, robots)
            X_PO = query.X_WF(frame) if link is None else _pose_on(query, frame, link)
            subframes = {
                inspector.GetName(each).removeprefix(f'{inspector.GetName(frame)}/'): X
                for each, X in _on(query, frame)
                if each not in by_frame
            }
            objects.append(MoveItObject(name_of(frame), X_PO, geometries, subframes, link, frame))
    return MoveItObjects(objects, of_robots, waiting)


def ids_of(objects: Sequence[MoveItObject]) -> list[str]:
    """Return ids of objects: their names without their source, where these are unique."""
    short = [each.name.split('::', 1)[1].removeprefix('world/') for each in objects]
    counts = Counter(short)
    return [
        own if counts[own] == 1 else each.name for own, each in zip(short, objects, strict=True)
    ]


def _owner(inspector: SceneGraphInspector, frame: FrameId) -> str:
    return inspector.GetName(inspector.GetOwningSourceId(frame))


def _carrier(
    inspector: SceneGraphInspector, frame: FrameId, robots: Collection[str]
) -> FrameId | None:
    """Return the link of a robot that a frame hangs on, None for none."""
    while frame != inspector.world_frame_id():
        if _owner(inspector, frame) in robots:
            return frame
        frame = inspector.GetParentFrame(frame)
    return None


def _pose_on(query: QueryObject, frame: FrameId, link: FrameId) -> RigidTransform:
    """Return the pose of a frame on a link that carries it, the same while the link moves."""
    inspector = query.inspector()
    X = query.X_PF(frame)
    while (frame := inspector.GetParentFrame(frame)) != link:
        X = query.X_PF(frame) @ X
    return X


def _on(query: QueryObject, frame: FrameId) -> list[tuple[FrameId, RigidTransform]]:
    """Return the frames on a frame, with their poses on it."""
    inspector = query.inspector()
    return [
        (each, query.X_PF(each))
        for each in inspector.GetAllFrameIds()
        if inspector.GetParentFrame(each) == frame and query.is_placed(each)
    ]
