"""Reader of a URDF's links and joints, which checks that they form trees.

Filters and forward kinematics share this reader, so that a pose in a file means the same to a
node, to ``check`` and to a player.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.description import WORLD
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.link_tree import Joint, LinkTree, Mimic, UrdfJoint
from drake_geom_ros.scene_files.robot_files import read_robot_file
from drake_geom_ros.scene_files.screws import screw_parts
from drake_geom_ros.scene_files.urdf_joint_checks import check_joint
from drake_geom_ros.scene_files.urdf_poses import pose_of
from drake_geom_ros.scene_files.xml_tree import (
    attribute,
    local_name,
    numbers,
    place_of,
    read_robot_xml,
)

_SHOWN = 5  # joints in a sentence
# Types of ``<drake:joint>``, and the one that no joint value moves.
DRAKES_TYPES = ('ball', 'planar', 'screw', 'universal')
UNDRIVEN = 'curvilinear'


def read_link_tree(path: str | Path, expand: bool = True) -> LinkTree:
    """Return the links and joints of a URDF file; with ``expand`` macros are expanded.

    Raises SceneFileError like ``read_links`` and ``read_joints``, and for a file that is no URDF.
    """
    data, file = read_robot_file(Path(path), expand)
    root = read_robot_xml(data, file)
    links = read_links(root, file)
    joints = read_joints(root, links, file)
    return LinkTree(attribute(root, 'name', file), tuple(links), tuple(joints))


def read_links(root: Any, file: str) -> dict[str, Any]:
    """Return the link elements by name.

    If a joint has the parent ``world`` and the file has no such link, there is an empty element
    without a parent for it, as in Drake and Gazebo.

    Raises SceneFileError, with the line, for no links, missing names, and two links of one name.
    """
    links: dict[str, Any] = {}
    for element in root.findall('link'):
        name = attribute(element, 'name', file)
        if name in links:
            first = links[name].sourceline
            raise place_of(element, file).error(f'link {name!r} is listed twice, see line {first}')
        links[name] = element
    if WORLD not in links and _names_world(root):
        links[WORLD] = root.makeelement('link', {'name': WORLD})
    if not links.keys() - {WORLD}:
        raise place_of(root, file).error(
            f'no links{f" but {WORLD!r}" if links else ""}; a robot has at least one'
        )
    return links


def _names_world(root: Any) -> bool:
    """Return whether the parent of a joint is the world."""
    joints = (element for element in root if local_name(element) == 'joint')
    parents = (joint.find('parent') for joint in joints)
    return any(parent is not None and parent.get('link') == WORLD for parent in parents)


def read_joints(root: Any, links: Mapping[str, Any], file: str) -> list[UrdfJoint]:
    """Return the joints of a URDF in its order; ``links`` are its link elements by name.

    Raises SceneFileError, with the line, for a joint without a name or a type, two of one name,
    one to a missing link, invalid numbers, a link with two parents, a ring, and values that
    ``urdf_joint_checks`` refuses.
    """
    joints: dict[str, UrdfJoint] = {}
    for element in root:
        if local_name(element) != 'joint' or element.get('type') == UNDRIVEN:
            continue
        joint = _joint(element, links, file)
        if joint.name in joints:
            first = joints[joint.name].where.line
            raise joint.where.error(f'joint {joint.name!r} is listed twice, see line {first}')
        joints[joint.name] = joint
    check_forest(list(joints.values()))
    return list(joints.values())


def root_links(joints: Iterable[Joint], links: Iterable[str]) -> list[str]:
    """Return the links that no joint has as its child, in their order."""
    children = {joint.child for joint in joints}
    return [link for link in links if link not in children]


def fixed_poses(
    joints: Iterable[UrdfJoint], root: str, X_WB: RigidTransform
) -> dict[str, RigidTransform]:
    """Return X_WL of the root link and of those that fixed joints hold to it, by name."""
    poses = {root: X_WB}
    for joint in parents_first(joints, root):
        if joint.type == 'fixed' and joint.parent in poses:
            poses[joint.child] = poses[joint.parent] @ joint.X_PJ
    return poses


def parents_first(joints: Iterable[UrdfJoint], root: str) -> list[UrdfJoint]:
    """Return the joints below a link, each after the joint above its parent link."""
    held: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        held.setdefault(joint.parent, []).append(joint)
    ordered: list[UrdfJoint] = []
    links = [root]
    for link in links:  # the loop appends to it
        ordered += held.get(link, ())
        links += [joint.child for joint in held.get(link, ())]
    return ordered


def _joint(element: Any, links: Mapping[str, Any], file: str) -> UrdfJoint:
    """Return the joint of an element; SceneFileError for one to a missing link."""
    where = place_of(element, file)
    name = attribute(element, 'name', file)
    kind = attribute(element, 'type', file)
    ends = []
    for end in ('parent', 'child'):
        child = element.find(end)
        if child is None:
            raise where.error(f'missing <{end} link="..."/>')
        link = attribute(child, 'link', file)
        if link not in links:
            raise place_of(child, file).error(f'link {link!r} is not in the file')
        ends.append(link)
    try:
        x, y, z = _finite(element.find('axis'), 'xyz', 3, '1 0 0')
        limits = _limits(element.find('limit'), kind)
        X_PJ, mimic = pose_of(element), _mimic(element.find('mimic'))
    except (ValueError, RuntimeError) as error:
        raise where.error(str(error)) from error
    joint = UrdfJoint(kind, ends[0], ends[1], name, X_PJ, (x, y, z), *limits, mimic, where)
    if element.tag != 'joint':
        return _drakes(joint, element)
    check_joint(joint, element)
    return joint


def _drakes(joint: UrdfJoint, element: Any) -> UrdfJoint:
    """Return the joint of a ``<drake:joint>``; ball and universal ones have no axis."""
    if joint.type not in DRAKES_TYPES:
        allowed = ', '.join((*DRAKES_TYPES, UNDRIVEN))
        raise joint.where.error(
            f'type {joint.type!r} is none of <drake:joint>, which are {allowed}'
        )
    if joint.type != 'screw':
        return joint
    pitches = [child for child in element if local_name(child) == 'screw_thread_pitch']
    if len(pitches) != 1:
        raise joint.where.error('a screw joint has one <drake:screw_thread_pitch value="..."/>')
    try:
        (pitch,) = _finite(pitches[0], 'value', 1, '0')
    except ValueError as error:
        raise joint.where.error(str(error)) from error
    return replace(joint, parts=screw_parts(joint, pitch))


def _limits(limit: Any, kind: str) -> tuple[float, float, float]:
    """Return lower, upper and speed limit; a bound that ``<limit>`` lacks counts as 0."""
    (speed,) = _finite(limit, 'velocity', 1, '0')
    speed = speed if speed > 0.0 else math.inf
    if limit is None or kind == 'continuous':
        return -math.inf, math.inf, speed
    (lower,), (upper,) = (_finite(limit, name, 1, '0') for name in ('lower', 'upper'))
    return lower, upper, speed


def _mimic(element: Any) -> Mimic | None:
    if element is None:
        return None
    if not element.get('joint'):
        raise ValueError('mimic has no attribute `joint`')
    (multiplier,) = _finite(element, 'multiplier', 1, '1')
    (offset,) = _finite(element, 'offset', 1, '0')
    return Mimic(element.get('joint'), multiplier, offset)


def _finite(element: Any, name: str, count: int, default: str) -> list[float]:
    """Return an attribute of finite numbers, or the default if there is no element."""
    if element is None:
        return [float(word) for word in default.split()]
    values = numbers(element, name, count, default)
    if not all(map(math.isfinite, values)):
        raise ValueError(f'{element.tag}: {name} = {element.get(name)!r} must be finite')
    return values


def check_forest(joints: list[UrdfJoint]) -> None:
    """Refuse a link with two parents, and joints that form a ring."""
    above: dict[str, UrdfJoint] = {}
    for joint in joints:
        if (other := above.setdefault(joint.child, joint)) is not joint:
            raise joint.where.error(
                f'link {joint.child!r} has two parents: joint {other.name!r} (line '
                f'{other.where.line}) holds it to {other.parent!r}, and this one to '
                f'{joint.parent!r}; links must form a tree'
            )
    rooted: set[str] = set()
    for joint in joints:
        passed: dict[str, UrdfJoint] = {}
        link = joint.child
        while link in above and link not in rooted:
            if link in passed:
                raise _ring(list(passed.values()))
            passed[link] = above[link]
            link = above[link].parent
        rooted |= passed.keys()


def _ring(passed: list[UrdfJoint]) -> SceneFileError:
    """Return the error about a ring in a chain of joints, each followed by the one above it."""
    start = next(k for k, joint in enumerate(passed) if joint.child == passed[-1].parent)
    ring = passed[start:][::-1]
    names = ', '.join(f'{joint.name!r} (line {joint.where.line})' for joint in ring[:_SHOWN])
    more = f' and {len(ring) - _SHOWN} more' if len(ring) > _SHOWN else ''
    return ring[0].where.error(f'joints form a ring: {names}{more}; links must form a tree')
