"""Removal of a source from a scene description."""

from __future__ import annotations

from dataclasses import replace

from drake_geom_ros.common.frame_names import full_name
from drake_geom_ros.scene_files.description import (
    DeclarationDescription,
    FilterDescription,
    FrameDescription,
    Member,
    SceneDescription,
    Statement,
)


def without_source(scene: SceneDescription, source: str) -> SceneDescription:
    """Return a scene without a source's robots, frames, geometries and filter members."""
    filters: list[FilterDescription] = []
    for entry in scene.filters:
        if isinstance(entry, DeclarationDescription):
            statements = tuple(filter(None, (_statement(s, source) for s in entry.statements)))
            if statements:
                filters.append(replace(entry, statements=statements))
        elif members := _others(entry.members, source):
            filters.append(replace(entry, members=members))
    return replace(
        scene,
        sources=tuple(name for name in scene.sources if name != source),
        robots=tuple(robot for robot in scene.robots if robot.name != source),
        frames=tuple(_not_touching(f, source) for f in scene.frames if f.source != source),
        geometries=tuple(geometry for geometry in scene.geometries if geometry.source != source),
        filters=tuple(filters),
    )


def _not_touching(frame: FrameDescription, source: str) -> FrameDescription:
    """Return a frame that may touch nothing of a source."""
    whole = full_name((source, ''))
    names = (n for n in frame.touch_links if n != source and not n.startswith(whole))
    return replace(frame, touch_links=tuple(names))


def _others(members: tuple[Member, ...], source: str) -> tuple[Member, ...]:
    return tuple(member for member in members if member.source != source)


def _statement(statement: Statement, source: str) -> Statement | None:
    """Return a statement without the members of a source; None if no pair remains."""
    set_a, set_b = _others(statement.set_a, source), _others(statement.set_b, source)
    if not set_a or (statement.operation.takes_two_sets and not set_b):
        return None
    return replace(statement, set_a=set_a, set_b=set_b)
