"""Collision filters of SDFormat: Drake's filter groups, and Gazebo's bitmasks and self collisions.

Two geometries of Gazebo collide if their ``collide_bitmask`` share a bit; the default has all 16.
"""

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from itertools import combinations_with_replacement
from typing import Any

from drake_geom_ros.geometry import FilterOperation
from drake_geom_ros.scene_files.description import (
    DeactivationDescription,
    DeclarationDescription,
    FilterDescription,
    GroupDescription,
    Member,
    Statement,
)
from drake_geom_ros.scene_files.errors import Location
from drake_geom_ros.scene_files.sdf_elements import text_of
from drake_geom_ros.scene_files.sdf_models import Item
from drake_geom_ros.scene_files.urdf_filters import RobotFilterGroup, group_name, members_of
from drake_geom_ros.scene_files.xml_tree import attribute, local_name

_ALL_BITS = 0xFFFF


def read_groups(
    items: Sequence[tuple[str, Item]], links: Collection[str], source: str
) -> tuple[list[GroupDescription], list[str]]:
    """Return the ``<drake:collision_filter_group>`` elements of a model, and warnings about them.

    Each item has the prefix of its scope, such as ``nested::``. Raises SceneFileError for a member
    that is no link, two groups of one name, and a member group that is missing.
    """
    groups: dict[str, RobotFilterGroup] = {}
    places: dict[str, tuple[Location, str]] = {}
    warnings: list[str] = []
    for prefix, item in items:
        if item.element.get('ignore', 'false') == 'true':
            continue
        name = prefix + attribute(item.element, 'name', item.file.name)
        where = item.file.at(item.element)
        if name in groups:
            raise where.error(f'group {name!r} is there twice')
        places[name] = where, item.file.name
        groups[name] = group = RobotFilterGroup(item.element, [], [], [])
        for child in item.element:
            kind, inner = local_name(child), prefix + text_of(child)
            if kind == 'member':
                if inner not in links:
                    raise item.file.at(child).error(f'link {inner!r} is not in the model')
                group.members.append(inner)
            elif kind == 'member_group':
                group.groups.append((child, inner))
            elif kind == 'ignored_collision_filter_group':
                group.ignores.append(inner)
            else:
                warning = f'<{kind}> is not understood; it is left out'
                warnings.append(str(item.file.at(child).error(warning)))
    described = [
        GroupDescription(
            group_name(name, source),
            tuple(Member(source, link) for link in members_of(name, groups, places[name][1])),
            tuple(group_name(other, source) for other in group.ignores),
            places[name][0],
        )
        for name, group in groups.items()
    ]
    return described, warnings


def bitmask_of(collision: Any) -> int:
    """Return Gazebo's bitmask of a collision element; ValueError for one that is no number."""
    surface = collision.find('surface')
    contact = None if surface is None else surface.find('contact')
    text = text_of(contact, 'collide_bitmask') if contact is not None else ''
    if not text:
        return _ALL_BITS
    try:
        return int(text, 0) & _ALL_BITS
    except ValueError:
        raise ValueError(f'<collide_bitmask> is {text!r}; it must be an integer') from None


def bitmask_filters(masks: Mapping[Member, int], where: Location) -> Iterator[FilterDescription]:
    """Yield the filters of the geometries whose bitmasks share no bit."""
    by_mask: defaultdict[int, list[Member]] = defaultdict(list)
    for member, mask in masks.items():
        by_mask[mask].append(member)
    if off := by_mask.pop(0, []):
        yield DeactivationDescription(tuple(off), where)
    statements = [
        Statement(FilterOperation.EXCLUDE_BETWEEN, tuple(by_mask[a]), tuple(by_mask[b]))
        for a, b in combinations_with_replacement(sorted(by_mask), 2)
        if not a & b
    ]
    if statements:
        yield DeclarationDescription(tuple(statements), where)
