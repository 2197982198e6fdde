"""Collision filters of a robot: filter groups of its URDF, and cliques of its joints.

Drake's elements have the meaning of Drake's parser, as observed with pydrake.
"""

from collections import defaultdict
from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

from drake_geom_ros.geometry import CollisionFilterManager
from drake_geom_ros.scene_files.description import (
    WORLD,
    CliqueDescription,
    GroupDescription,
    Member,
    RobotOptions,
)
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.link_tree import Joint
from drake_geom_ros.scene_files.urdf_tree import UNDRIVEN
from drake_geom_ros.scene_files.xml_tree import attribute, local_name, place_of


def moved_links(joints: Sequence[Joint]) -> set[str]:
    """Return the links that move against the root, below a joint that is not fixed."""
    children = defaultdict(list)
    for joint in joints:
        children[joint.parent].append(joint.child)
    moved: set[str] = set()
    fresh = [joint.child for joint in joints if joint.type != 'fixed']
    while fresh:
        link = fresh.pop()
        if link not in moved:
            moved.add(link)
            fresh += children[link]
    return moved


def undriven_joints(root: Any, links: Collection[str], file: str) -> list[Joint]:
    """Return the ``<drake:joint>`` elements that no joint value moves.

    Raises SceneFileError for an end that is missing or not a link of the file.
    """
    return [
        _undriven(element, links, file)
        for element in root
        if local_name(element) == 'joint' and element.get('type') == UNDRIVEN
    ]


def _undriven(element: Any, links: Collection[str], file: str) -> Joint:
    place = place_of(element, file)
    ends = []
    for name in ('parent', 'child'):
        if (end := element.find(name)) is None:
            raise place.error(f'missing <{name} link="..."/>')
        link = attribute(end, 'link', file)
        if link not in links:
            raise place_of(end, file).error(f'link {link!r} is not in the file')
        ends.append(link)
    return Joint(UNDRIVEN, *ends)


@dataclass
class RobotFilterGroup:
    """A group as read from its element; ``groups`` are those whose members it includes."""

    element: Any
    members: list[str]
    groups: list[tuple[Any, str]]
    ignores: list[str]


def welded_links(joints: Sequence[Joint], options: RobotOptions) -> set[str]:
    """Return the links that fixed joints hold to the link ``world``.

    None if adjacent links are not filtered.
    """
    bodies = _fixed_bodies(joints) if options.filter_adjacent_links else []
    return {link for body in bodies if WORLD in body for link in body} - {WORLD}


def read_groups(
    root: Any, file: str, source: str
) -> tuple[tuple[GroupDescription, ...], tuple[str, ...]]:
    """Return the ``<collision_filter_group>`` elements of a URDF, and warnings about them.

    Both of Drake's spellings are read: the older one has
    ``<ignored_collision_filter_group collision_filter_group="...">``, the newer one the prefix
    ``drake:`` and ``name="..."``. Groups with ``ignore="true"`` are skipped. ``<member_group>``
    adds the members of another group, in any order. Group ``g`` of the robot ``left`` gets the
    name ``left::g``, so that two robots of one URDF do not share it; only ``universal`` is shared
    by all robots. Raises SceneFileError for a member that the URDF does not have, and for two
    groups of one name; ignoring a group that does not exist is allowed.
    """
    links = {link.get('name') for link in root.findall('link')} - {WORLD}
    groups: dict[str, RobotFilterGroup] = {}
    warnings: list[str] = []
    for element in root:
        if local_name(element) != 'collision_filter_group':
            continue
        place = place_of(element, file)
        ignored = element.get('ignore', 'false')
        if ignored == 'true':
            continue
        if ignored != 'false':
            warning = f'ignore = {ignored!r} is not `true`: the group counts, as in Drake'
            warnings.append(str(place.error(warning)))
        name = attribute(element, 'name', file)
        if name in groups:
            first = groups[name].element.sourceline
            raise place.error(f'group {name!r} is there twice, see line {first}')
        groups[name] = _read_group(element, links, file, warnings)
    described = tuple(
        GroupDescription(
            group_name(name, source),
            tuple(Member(source, link) for link in members_of(name, groups, file)),
            tuple(group_name(other, source) for other in group.ignores),
            place_of(group.element, file),
        )
        for name, group in groups.items()
    )
    return described, tuple(warnings)


def _read_group(
    element: Any, links: Collection[str], file: str, warnings: list[str]
) -> RobotFilterGroup:
    group = RobotFilterGroup(element, [], [], [])
    for child in element:
        kind, place = local_name(child), place_of(child, file)
        if kind == 'member':
            link = attribute(child, 'link', file)
            if link not in links:
                raise place.error(f'link {link!r} is not in the file')
            group.members.append(link)
        elif kind == 'member_group':
            group.groups.append((child, attribute(child, 'name', file)))
        elif kind == 'ignored_collision_filter_group':
            older = child.get('collision_filter_group')
            group.ignores.append(older or attribute(child, 'name', file))
        else:
            warnings.append(str(place.error(f'<{kind}> is not understood; it is left out')))
    return group


def members_of(name: str, groups: Mapping[str, RobotFilterGroup], file: str) -> list[str]:
    """Return the links of a group and of its member groups, each once."""
    members: dict[str, None] = {}
    fresh, seen = [name], {name}
    while fresh:
        group = groups[fresh.pop()]
        members |= dict.fromkeys(group.members)
        for element, other in group.groups:
            if other not in groups:
                raise place_of(element, file).error(f'group {other!r} is not in the file')
            if other not in seen:
                seen.add(other)
                fresh.append(other)
    return list(members)


def group_name(name: str, source: str) -> str:
    """Return the name of a robot's group in the scene."""
    universal = CollisionFilterManager.universal_group_name()
    return universal if name == universal else f'{source}::{name}'


def adjacent_cliques(
    joints: Sequence[Joint], with_geometry: Collection[str], source: str, options: RobotOptions
) -> Iterator[CliqueDescription]:
    """Yield the cliques of ``adjacent_links``, if the options filter them."""
    if not options.filter_adjacent_links:
        return
    for links in adjacent_links(joints, with_geometry):
        name = ' - '.join(links.links) if links.are_jointed else f'fixed to {links.links[0]}'
        yield _clique(f'{source}: {name}', source, links.links)


class AdjacentLinks(NamedTuple):
    """Links with geometry that a moving joint connects, or that fixed joints hold together."""

    links: tuple[str, ...]
    are_jointed: bool


def adjacent_links(
    joints: Sequence[Joint], with_geometry: Collection[str]
) -> Iterator[AdjacentLinks]:
    """Yield the sets of adjacent links of a robot, as in Drake.

    Each two links that a moving joint connects are one, and so is each body of links that fixed
    joints hold together. A floating joint connects nothing, since its child may be anywhere. Links
    without geometry are in no set, but fixed bodies extend across them: a hand on an empty flange
    is adjacent to the link that the flange is fixed to. A moving joint does not: a link beyond the
    joint of such a flange is adjacent to none.
    """
    for joint in joints:
        ends = (joint.parent, joint.child)
        if joint.type not in ('fixed', 'floating') and all(link in with_geometry for link in ends):
            yield AdjacentLinks(ends, True)
    for body in _fixed_bodies(joints):
        links = tuple(link for link in body if link in with_geometry)
        if len(links) > 1:
            yield AdjacentLinks(links, False)


def links_fixed_to(joints: Sequence[Joint], link: str) -> list[str]:
    """Return a link and those that fixed joints hold to it."""
    bodies = (body for body in _fixed_bodies(joints) if link in body)
    return next(bodies, [link])


def self_cliques(
    with_geometry: Collection[str], source: str, options: RobotOptions
) -> Iterator[CliqueDescription]:
    """Yield the clique of all links, if the option ``filter_self_collisions`` is set."""
    if options.filter_self_collisions:
        yield _clique(f'{source}: all links', source, sorted(with_geometry))


def _clique(name: str, source: str, links: Sequence[str]) -> CliqueDescription:
    place = Location(f'robot {source}', key=name)
    return CliqueDescription(name, tuple(Member(source, link) for link in links), place)


def _fixed_bodies(joints: Sequence[Joint]) -> list[list[str]]:
    """Return the sets of links that fixed joints connect, in the order of the joints."""
    return bodies_of((joint.parent, joint.child) for joint in joints if joint.type == 'fixed')


_Link = TypeVar('_Link', bound=Hashable)


def bodies_of(fixed: Iterable[tuple[_Link, _Link]]) -> list[list[_Link]]:
    """Return the sets of links that pairs of them connect, in the order of the pairs."""
    held: defaultdict[_Link, list[_Link]] = defaultdict(list)
    links: dict[_Link, None] = {}  # in the order of the pairs
    for parent, child in fixed:
        held[parent].append(child)
        held[child].append(parent)
        links.update(dict.fromkeys((parent, child)))
    bodies: list[set[_Link]] = []
    seen: set[_Link] = set()
    for link in links:
        if link in seen:
            continue
        body, fresh = {link}, [link]
        while fresh:
            near = [other for other in held[fresh.pop()] if other not in body]
            body.update(near)
            fresh += near
        seen |= body
        bodies.append(body)
    place = {link: k for k, link in enumerate(links)}
    return [sorted(body, key=place.__getitem__) for body in bodies]
