"""Scenes of several models that welds hold to the world and to each other."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import (
    WORLD,
    CliqueDescription,
    FilterDescription,
    FrameDescription,
    Member,
    RobotDescription,
    RobotOptions,
    SceneDescription,
)
from drake_geom_ros.scene_files.directive_names import LinkFrame
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.grounding import (
    fixed_in_world,
    free_links,
    grounded,
    without_world,
)
from drake_geom_ros.scene_files.mounting import carried
from drake_geom_ros.scene_files.robot_parts import RobotParts
from drake_geom_ros.scene_files.urdf_filters import bodies_of

ModelParts = tuple[RobotDescription, RobotParts]
_WORLD = Member('', WORLD)


@dataclass(frozen=True)
class Weld:
    """A fixed joint between two links; X_PC is the pose of the child in the parent."""

    parent: Member
    child: Member
    X_PC: RigidTransform
    where: Location


def welded_scene(
    file: str,
    models: Iterable[ModelParts],
    welds: Sequence[Weld],
    free: Mapping[Member, LinkFrame],
    groups: Iterable[FilterDescription],
    options: RobotOptions,
) -> SceneDescription:
    """Return the scene of models, welds and poses of free links.

    Raises SceneFileError for a weld whose child is the world, or a link that something else
    holds, and for a pose of a link that is not free or whose base frame has no pose itself.
    """
    held = {
        robot.name: (robot, replace(parts, tree=grounded(parts.tree))) for robot, parts in models
    }
    for weld in welds:
        if weld.child == _WORLD:
            raise weld.where.error('the child is the world; let the other link be the child')
        held[weld.child.source] = _welded(*held[weld.child.source], weld)
    _check_circles(held)
    for link, frame in free.items():
        held[link.source] = _freed(*held[link.source], link, frame, held)
    placed = [_placed(*model) for model in held.values()]
    frames = [frame for _, parts in placed for frame in parts.frames]
    for robot, _ in placed:
        if robot.mounted_on is not None:
            frames = carried(frames, robot, robot.mounted_on)
    filters = [entry for _, parts in placed for entry in parts.filters]
    bodies = bodies_of(_fixed_joints(placed, welds)) if options.filter_adjacent_links else []
    shaped = {(g.source, g.frame) for _, parts in placed for g in parts.geometries}
    return SceneDescription(
        file,
        sources=tuple(robot.name for robot, _ in placed),
        robots=tuple(robot for robot, _ in placed),
        frames=tuple(_anchored(frames, bodies)),
        geometries=tuple(g for _, parts in placed for g in parts.geometries),
        filters=(*filters, *groups, *_cliques(bodies, shaped, file)),
        warnings=tuple(warning for _, parts in placed for warning in parts.warnings),
    )


def _welded(robot: RobotDescription, parts: RobotParts, weld: Weld) -> ModelParts:
    """Return a model that a weld holds by one of its free links."""
    link, tree = weld.child.frame, parts.tree
    if parts.is_welded or link not in free_links(tree):
        raise weld.where.error(
            f'{link!r} of {robot.name!r} cannot be the child: a joint or a weld holds it, or it '
            f'is not the root of its model; free are {", ".join(free_links(tree)) or "none"}'
        )
    if weld.parent == _WORLD and WORLD in tree.links:
        tree = fixed_in_world(tree, link, weld.X_PC)
        return robot, replace(parts, tree=tree)
    alone = without_world(tree, link)
    if alone is None:
        raise weld.where.error(f'{robot.name!r} has several roots; weld each to the world')
    parts = replace(parts, tree=alone, X_WB=weld.X_PC, X_WLs={}, is_welded=True)
    on = None if weld.parent == _WORLD else weld.parent
    return replace(robot, mounted_on=on), parts


def _check_circles(held: Mapping[str, ModelParts]) -> None:
    for start, (robot, _) in held.items():
        passed = {start}
        while robot.mounted_on is not None:
            if robot.mounted_on.source in passed:
                raise robot.where.error(f'welds carry the model {start!r} in a circle')
            passed.add(robot.mounted_on.source)
            robot = held[robot.mounted_on.source][0]


def _freed(
    robot: RobotDescription,
    parts: RobotParts,
    link: Member,
    frame: LinkFrame,
    held: Mapping[str, ModelParts],
) -> ModelParts:
    """Return a model with the first pose of a free link, or of one that is fixed to it."""
    X_WL = frame.X_LF
    if frame.link != _WORLD:
        base = _pose_in_world(frame.link, held)
        if base is None:
            raise robot.where.error(
                f'the pose of {link.frame!r} counts from {frame.link.frame!r} of '
                f'{frame.link.source!r}, which has no pose itself'
            )
        X_WL = base @ X_WL
    if not parts.is_welded and link.frame in free_links(parts.tree):
        if WORLD in parts.tree.links:
            return robot, replace(parts, X_WLs={**parts.X_WLs, link.frame: X_WL})
        return robot, replace(parts, X_WB=X_WL)
    raise robot.where.error(f'{link.frame!r} is not a free link, so it has no pose of its own')


def _pose_in_world(link: Member, held: Mapping[str, ModelParts]) -> RigidTransform | None:
    """Return the first pose of a link in the world, None if it has none."""
    robot, parts = _placed(*held[link.source])
    X_PL = next(frame.X_PF for frame in parts.frames if frame.name == link.frame)
    if X_PL is None or robot.mounted_on is None:
        return X_PL
    X_WP = _pose_in_world(robot.mounted_on, held)
    return None if X_WP is None else X_WP @ X_PL


def _placed(robot: RobotDescription, parts: RobotParts) -> ModelParts:
    """Return a model with the first poses of its frames, as far as these are known.

    One whose tree is no longer that of its file has no file, so that it is not read again.
    """
    root_is_world = WORLD in parts.tree.links
    if parts.X_WB is not None or root_is_world:
        X_WB = RigidTransform() if parts.X_WB is None or root_is_world else parts.X_WB
        parts = parts.placed(X_WB, robot.configuration)
        robot = replace(robot, X_WB=X_WB)
    else:
        robot = replace(robot, X_WB=RigidTransform())
    is_changed = parts.tree is not robot.tree
    return replace(robot, tree=parts.tree, urdf=None if is_changed else robot.urdf), parts


def _fixed_joints(
    models: Iterable[ModelParts], welds: Iterable[Weld]
) -> Iterator[tuple[Member, Member]]:
    """Yield the two links of each fixed joint and each weld."""
    for robot, parts in models:
        for joint in parts.joints:
            if joint.type == 'fixed':
                yield _member(robot.name, joint.parent), Member(robot.name, joint.child)
    for weld in welds:
        yield weld.parent, weld.child


def _member(source: str, link: str) -> Member:
    return _WORLD if link == WORLD else Member(source, link)


def _anchored(
    frames: Iterable[FrameDescription], bodies: Iterable[Sequence[Member]]
) -> Iterator[FrameDescription]:
    """Yield the frames, those that fixed joints hold to the world as welded to it."""
    anchored = {member for body in bodies if _WORLD in body for member in body}
    for frame in frames:
        is_held = Member(frame.source, frame.name) in anchored
        yield replace(frame, welded=True) if is_held else frame


def _cliques(
    bodies: Iterable[Sequence[Member]], shaped: set[tuple[str, str]], file: str
) -> Iterator[CliqueDescription]:
    """Yield the clique of each body that has links of several models."""
    for body in bodies:
        members = tuple(each for each in body if (each.source, each.frame) in shaped)
        if len({member.source for member in members}) > 1:
            first = members[0]
            name = f'fixed to {first.source}::{first.frame}'
            yield CliqueDescription(name, members, Location(file, key=name))
