"""SRDF -> collision filters of one robot, with MoveIt's meaning.

Of an SRDF count the pairs that it switches off and on again, and the states of groups that the
robot's key ``configuration`` names (``standing``); groups, end effectors, passive joints,
properties and the spheres that stand for a link change no answer here.
Where the base stands is not read from ``virtual_joint``: the robot's key ``pose``, TF or messages
say it. Source of the meaning: MoveIt's AllowedCollisionMatrix and srdfdom.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from drake_geom_ros.geometry import CollisionFilterManager
from drake_geom_ros.scene_files.description import (
    WORLD,
    DeclarationDescription,
    FilterDescription,
    GroupDescription,
    Member,
    Operation,
    RobotOptions,
    Statement,
)
from drake_geom_ros.scene_files.xml_tree import (
    XACRO_FIRST,
    attribute,
    local_name,
    place_of,
    read_robot_xml,
)

_DISABLED, _ENABLED = 'disable_collisions', 'enable_collisions'
_DEFAULT_OFF, _BASE = 'disable_default_collisions', 'virtual_joint'
# The attributes that name links.
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
    """What an SRDF says of pairs; ``warnings`` are what was left out of it, and why."""

    filters: tuple[FilterDescription, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Entry:
    """An element, with the links that it names, all of which the robot has."""

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

    A link of ``disable_default_collisions`` is in no pair, not even with what comes later, unless
    ``enable_collisions`` names the pair; ``disable_collisions`` has the last word, whatever the
    order in the file. Those with the reason ``Adjacent`` count only with
    ``filter_adjacent_links``, and nothing is enabled with ``filter_self_collisions``.
    An entry with a link that the robot does not have is left out, and a warning names it.
    Raises SceneFileError for what is no SRDF, and for xacro that nobody expanded.
    """
    root = read_robot_xml(data, file)
    warnings = list(_not_understood(root, file))
    if (name := attribute(root, 'name', file)) != robot:
        told = f'the SRDF is of the robot {name!r}, the URDF of {robot!r}'
        warnings.append(str(place_of(root, file).error(told)))
    entries: dict[str, list[_Entry]] = {tag: [] for tag in _LINKS}
    for tag, found in entries.items():
        for element in root.iterfind(tag):
            named = tuple(attribute(element, end, file).strip() for end in _LINKS[tag])
            unknown = [link for link in named if link not in {*links, WORLD}]
            if unknown:
                told = f'link {unknown[0]!r} is not in the robot {source!r}; the entry is left out'
                warnings.append(str(place_of(element, file).error(told)))
            elif WORLD not in named:  # that link has no shapes, so the entry says nothing
                found.append(_Entry(element, named))
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


def _statements(
    entries: dict[str, list[_Entry]], source: str, options: RobotOptions
) -> Iterator[Statement]:
    """Yield what is said of single pairs; the last word counts."""
    enabled = [] if options.filter_self_collisions else entries[_ENABLED]
    disabled = [
        entry
        for entry in entries[_DISABLED]
        if options.filter_adjacent_links or entry.element.get('reason') != 'Adjacent'
    ]
    for operation, pairs in (
        (Operation.ALLOW_BETWEEN, enabled),
        (Operation.EXCLUDE_BETWEEN, disabled),
    ):
        for entry in pairs:
            first, second = ((Member(source, link),) for link in entry.links)
            yield Statement(operation, first, second)


def _not_understood(root: Any, file: str) -> Iterator[str]:
    """Yield what an SRDF says that is left out without being known to mean nothing here.

    Each kind once. Raises SceneFileError for xacro.
    """
    told = set()
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
        if lost and why not in told and element is not root:
            told.add(why)
            yield str(place_of(element, file).error(f'{why}; it is left out'))
