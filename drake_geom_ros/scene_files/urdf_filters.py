"""Collision filters of a robot: filter groups of its URDF, cliques of its joints, its SRDF."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import CollisionFilterManager
from drake_geom_ros.scene_files.description import (
    CliqueDescription,
    DeclarationDescription,
    GroupDescription,
    Member,
    Operation,
    RobotOptions,
    Statement,
)
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.xml_tree import attribute, local_name, place_of, read_robot_xml


@dataclass(frozen=True)
class Joint:
    """What holds two links together."""

    type: str
    parent: str
    child: str


def moved_links(joints: Sequence[Joint]) -> set[str]:
    """Return the links that move against the root: those with a joint that is not fixed above."""
    moved: set[str] = set()
    fresh = {joint.child for joint in joints if joint.type != 'fixed'}
    while fresh:
        moved |= fresh
        fresh = {joint.child for joint in joints if joint.parent in fresh} - moved
    return moved


def read_groups(root: Any, file: str, source: str) -> tuple[GroupDescription, ...]:
    """Return the ``<collision_filter_group>`` elements of a URDF, in either of Drake's spellings.

    The older one has ``<ignored_collision_filter_group collision_filter_group="...">``, the newer
    one the prefix ``drake:`` and ``name="..."``. Names are those of the robot: group ``g`` of
    ``left`` is ``left::g``, so that two robots of one URDF do not share it. Only ``universal`` is
    no robot's own: all belong to it.
    Raises SceneFileError for a member link that the URDF does not have; to ignore a group that
    does not exist is no error.
    """
    links = {link.get('name') for link in root.findall('link')}
    return tuple(
        _read_group(element, links, file, source)
        for element in root
        if local_name(element) == 'collision_filter_group'
    )


def _read_group(element: Any, links: Collection[str], file: str, source: str) -> GroupDescription:
    members, ignores = [], []
    for child in element:
        if local_name(child) == 'member':
            link = attribute(child, 'link', file)
            if link not in links:
                raise place_of(child, file).error(f'link {link!r} is not in the file')
            members.append(Member(source, link))
        elif local_name(child) == 'ignored_collision_filter_group':
            older = child.get('collision_filter_group')
            ignores.append(_group_name(older or attribute(child, 'name', file), source))
    name = _group_name(attribute(element, 'name', file), source)
    return GroupDescription(name, tuple(members), tuple(ignores), place_of(element, file))


def _group_name(name: str, source: str) -> str:
    """Return what a group of a robot is called in the scene."""
    universal = CollisionFilterManager.universal_group_name()
    return universal if name == universal else f'{source}::{name}'


def adjacent_cliques(
    joints: Sequence[Joint], with_geometry: Collection[str], source: str, options: RobotOptions
) -> Iterator[CliqueDescription]:
    """Yield a clique for each two links that a moving joint connects, and for each fixed body.

    A fixed body is a set of links that fixed joints hold together. Links without geometry carry
    no filter, but fixed joints reach through them: a hand that is screwed to the last link by
    way of an empty flange does not collide with that link.
    """
    if not options.filter_adjacent_links:
        return
    for joint in joints:
        ends = (joint.parent, joint.child)
        if joint.type != 'fixed' and all(link in with_geometry for link in ends):
            yield _clique(f'{source}: {joint.parent} - {joint.child}', source, ends)
    for body in _fixed_bodies(joints):
        links = [link for link in body if link in with_geometry]
        if len(links) > 1:
            yield _clique(f'{source}: fixed to {links[0]}', source, links)


def self_cliques(
    with_geometry: Collection[str], source: str, options: RobotOptions
) -> Iterator[CliqueDescription]:
    """Yield the one clique that switches off all collisions of a robot with itself, if asked."""
    if options.filter_self_collisions:
        yield _clique(f'{source}: all links', source, sorted(with_geometry))


def _clique(name: str, source: str, links: Sequence[str]) -> CliqueDescription:
    place = Location(f'robot {source}', key=name)
    return CliqueDescription(name, tuple(Member(source, link) for link in links), place)


def _fixed_bodies(joints: Sequence[Joint]) -> list[list[str]]:
    """Return the sets of links that fixed joints connect, in the order of the joints."""
    body_of: dict[str, list[str]] = {}
    for joint in joints:
        if joint.type == 'fixed':
            parent = body_of.setdefault(joint.parent, [joint.parent])
            child = body_of.setdefault(joint.child, [joint.child])
            if parent is not child:
                parent += child
                body_of.update(dict.fromkeys(child, parent))
    return list({id(body): body for body in body_of.values()}.values())


def read_srdf(
    data: bytes,
    file: str,
    source: str,
    links: Collection[str],
    filter_adjacent_links: bool = True,
) -> DeclarationDescription:
    """Return the ``<disable_collisions link1= link2=>`` elements of an SRDF as one declaration.

    Those that give ``Adjacent`` as their reason count only with ``filter_adjacent_links``.
    Raises SceneFileError for a link that the robot does not have.
    """
    statements = []
    root = read_robot_xml(data, file)
    for element in root.iter('disable_collisions'):
        ends = [attribute(element, name, file) for name in ('link1', 'link2')]
        for link in ends:
            if link not in links:
                reason = f'link {link!r} is not in the robot {source!r}'
                raise place_of(element, file).error(reason)
        if element.get('reason') == 'Adjacent' and not filter_adjacent_links:
            continue
        first, second = ((Member(source, link),) for link in ends)
        statements.append(Statement(Operation.EXCLUDE_BETWEEN, first, second))
    return DeclarationDescription(tuple(statements), place_of(root, file))
