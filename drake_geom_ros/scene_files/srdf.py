"""Collision filters of a robot from its SRDF, with MoveIt's meaning.

An SRDF contributes its disabled and enabled pairs, the states of groups that the robot's key
``configuration`` names, passive joints (``standing``), and the links of its groups, which an
attached part may touch. End effectors, properties and sphere approximations of links change no
answer here. The pose of the base is not read from ``virtual_joint``, but from the robot's key
``pose``, TF or messages; MoveIt's planning scenes call it by the name of that joint.
Sources of the meaning: MoveIt's AllowedCollisionMatrix, RobotModel and srdfdom.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import CollisionFilterManager, FilterOperation
from drake_geom_ros.scene_files.description import (
    WORLD,
    DeclarationDescription,
    FilterDescription,
    GroupDescription,
    Member,
    RobotOptions,
    Statement,
)
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.xml_tree import (
    XACRO_FIRST,
    attribute,
    local_name,
    place_of,
    robot_xml,
)

_DISABLED, _ENABLED = 'disable_collisions', 'enable_collisions'
_DEFAULT_OFF, _BASE = 'disable_default_collisions', 'virtual_joint'
# Attributes that name links, by tag.
_LINKS = {
    _DISABLED: ('link1', 'link2'),
    _ENABLED: ('link1', 'link2'),
    _DEFAULT_OFF: ('link',),
    _BASE: ('child_link',),
}
_WITHOUT_EFFECT = {
    *('group', 'group_state', 'end_effector', 'passive_joint', 'joint_property'),
    'link_sphere_approximation',
}


@dataclass(frozen=True)
class Semantics:
    """Filters of an SRDF, and warnings about skipped entries with their reasons."""

    filters: tuple[FilterDescription, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _LinksElement:
    """An element with the links that it names, all of which the robot has."""

    element: Any
    links: tuple[str, ...]


def read_srdf(
    data: bytes,
    file: str,
    source: str,
    robot: str,
    links: Collection[str],
    options: RobotOptions,
) -> Semantics:
    """Return the filters of an SRDF for ``source``, whose URDF names the ``robot`` and its links.

    A link of ``disable_default_collisions`` is in no pair, also with geometries that are added
    later, unless ``enable_collisions`` names the pair. ``disable_collisions`` overrides both,
    whatever the order in the file; entries with the reason ``Adjacent`` count only with
    ``filter_adjacent_links``. With ``filter_self_collisions`` nothing is enabled. An entry with
    an unknown link is skipped with a warning. Raises SceneFileError for a file that is no SRDF,
    and for xacro that was not expanded.
    """
    with robot_xml(data, file) as root:
        return _semantics_of(root, file, source, robot, links, options)


def _semantics_of(
    root: Any,
    file: str,
    source: str,
    robot: str,
    links: Collection[str],
    options: RobotOptions,
) -> Semantics:
    """Return the filters of an SRDF by its root element."""
    warnings = list(_not_understood(root, file))
    if (name := attribute(root, 'name', file)) != robot:
        warning = f'the SRDF is of the robot {name!r}, the URDF of {robot!r}'
        warnings.append(str(place_of(root, file).error(warning)))
    entries: dict[str, list[_LinksElement]] = {tag: [] for tag in _LINKS}
    for tag, entries_of_tag in entries.items():
        for element in root.iterfind(tag):
            named = tuple(attribute(element, end, file).strip() for end in _LINKS[tag])
            unknown = [link for link in named if link not in {*links, WORLD}]
            if unknown:
                warning = (
                    f'link {unknown[0]!r} is not in the robot {source!r}; the entry is left out'
                )
                warnings.append(str(place_of(element, file).error(warning)))
            elif WORLD not in named:  # that link has no shapes, so the entry has no effect
                entries_of_tag.append(_LinksElement(element, named))
    filters: list[FilterDescription] = []
    if off := [link for entry in entries[_DEFAULT_OFF] for link in entry.links]:
        members = tuple(Member(source, link) for link in dict.fromkeys(off))
        everything = CollisionFilterManager.universal_group_name()
        where = place_of(entries[_DEFAULT_OFF][0].element, file)
        name = f'{source}: {_DEFAULT_OFF}'
        filters.append(GroupDescription(name, members, (everything,), where))
    statements = tuple(_statements(entries, source, options))
    filters.append(DeclarationDescription(statements, place_of(root, file)))
    return Semantics(tuple(filters), tuple(warnings))


def link_groups(data: bytes, file: str, tree: LinkTree) -> dict[str, tuple[str, ...]]:
    """Return the links of each group of an SRDF, in the order of the robot's file.

    As in MoveIt, a group has the links that it lists, the child links of its joints, the links of
    its chains below the last link that both ends hang on, and those of the groups that it lists.
    Links and joints that the robot does not have are skipped.
    """
    with robot_xml(data, file) as root:
        elements = {attribute(each, 'name', file): each for each in root.findall('group')}
        return {
            name: tuple(n for n in tree.links if n in _links_of(name, elements, tree, file))
            for name in elements
        }


def virtual_joints(data: bytes, file: str, links: Collection[str]) -> dict[str, str]:
    """Return the child link of each virtual joint of an SRDF by name, of links of the robot."""
    with robot_xml(data, file) as root:
        children = {
            attribute(each, 'name', file): attribute(each, 'child_link', file).strip()
            for each in root.findall(_BASE)
        }
    return {name: link for name, link in children.items() if link in links}


def _links_of(
    name: str, groups: Mapping[str, Any], tree: LinkTree, file: str, within: tuple[str, ...] = ()
) -> set[str]:
    """Return the links of a group; a group that contains itself adds nothing."""
    if name not in groups or name in within:
        return set()
    element, above = groups[name], {joint.child: joint.parent for joint in tree.joints}
    links = {attribute(each, 'name', file) for each in element.findall('link')}
    joints = {attribute(each, 'name', file) for each in element.findall('joint')}
    links |= {joint.child for joint in tree.joints if joint.name in joints}
    for chain in element.findall('chain'):
        ends = (attribute(chain, end, file) for end in ('base_link', 'tip_link'))
        from_base, from_tip = (set(_up_from(link, above)) for link in ends)
        links |= from_base ^ from_tip
    for each in element.findall('group'):
        links |= _links_of(attribute(each, 'name', file), groups, tree, file, (*within, name))
    return links


def _up_from(link: str, above: Mapping[str, str]) -> Iterator[str]:
    """Yield a link and those that it hangs on, up to the root."""
    yield link
    while link in above:
        link = above[link]
        yield link


def _statements(
    entries: dict[str, list[_LinksElement]], source: str, options: RobotOptions
) -> Iterator[Statement]:
    """Yield the statements about single pairs; later ones override earlier ones."""
    enabled = [] if options.filter_self_collisions else entries[_ENABLED]
    disabled = [
        entry
        for entry in entries[_DISABLED]
        if options.filter_adjacent_links or entry.element.get('reason') != 'Adjacent'
    ]
    for operation, pairs in (
        (FilterOperation.ALLOW_BETWEEN, enabled),
        (FilterOperation.EXCLUDE_BETWEEN, disabled),
    ):
        for entry in pairs:
            first, second = ((Member(source, link),) for link in entry.links)
            yield Statement(operation, first, second)


def _not_understood(root: Any, file: str) -> Iterator[str]:
    """Yield warnings about skipped elements that may matter, one for each kind.

    Raises SceneFileError for xacro.
    """
    reported = set()
    for element in root.iter():
        if 'xacro' in (element.prefix or ''):
            raise place_of(element, file).error(
                f'<{element.prefix}:{local_name(element)}> is xacro: {XACRO_FIRST}'
            )
        tag = str(element.tag)
        if element.getparent() is root:
            lost = tag not in _LINKS and tag not in _WITHOUT_EFFECT
            why = f'<{local_name(element)}> is not understood'
        else:
            lost = tag in _LINKS
            why = f'<{tag}> counts directly in <robot> only'
        if lost and why not in reported and element is not root:
            reported.add(why)
            yield str(place_of(element, file).error(f'{why}; it is left out'))
