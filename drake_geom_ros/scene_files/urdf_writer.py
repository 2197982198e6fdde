"""Writer of one robot as URDF, with Drake's elements for what the plain format lacks.

A URDF holds links, joints and collision elements. Everything else is refused by name, so that no
pair, pose or shape is lost. The text is read again, and must have the same candidate pairs.
"""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

from lxml import etree

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HeightField,
    Mesh,
    ProximityProperties,
    Role,
    SceneGraph,
    Shape,
    Sphere,
)
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files.description import (
    WORLD,
    GeometryDescription,
    RobotDescription,
    RobotOptions,
    SceneDescription,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.jointed_links import parts_of
from drake_geom_ros.scene_files.link_tree import LinkTree, UrdfJoint
from drake_geom_ros.scene_files.registration import register
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.urdf import read_urdf
from drake_geom_ros.scene_files.urdf_proximity import write_properties

_DRAKE = 'http://drake.mit.edu'
_FREE = ('floating', 'planar')  # joints without values in a URDF
_UNLIMITED = 1e308  # of a prismatic joint: urdfdom reads a missing limit as 0
_SHOWN = 5  # names in a message
_LENGTHS = {
    Sphere: ('sphere', ('radius',)),
    Cylinder: ('cylinder', ('radius', 'length')),
    Capsule: ('capsule', ('radius', 'length')),
    Ellipsoid: (f'{{{_DRAKE}}}ellipsoid', ('a', 'b', 'c')),
}
_Pairs = set[frozenset[tuple[str, str]]]


def to_urdf(scene: SceneDescription) -> str:
    """Return the URDF of a scene of one robot; SceneFileError names what the format cannot hold.

    A scene of one body, such as a mesh file, is a robot of one link.
    Mesh files are named by ``file://`` and their absolute path. A joint of several values becomes
    a chain of simple ones, by the names that its values have here (``j/yaw``).
    """
    scene = _with_robot(scene)
    robot = _only_robot(scene)
    root = etree.Element('robot', name=robot.name, nsmap={'drake': _DRAKE})
    joints = (*_base_joint(robot, scene), *(robot.tree.joints if robot.tree else ()))
    by_link: defaultdict[str, list[GeometryDescription]] = defaultdict(list)
    for geometry in scene.geometries:
        by_link[geometry.frame].append(geometry)
    has_world = WORLD in by_link or any(joint.parent == WORLD for joint in joints)
    for link in dict.fromkeys((*[WORLD] * has_world, *(frame.name for frame in scene.frames))):
        element = etree.SubElement(root, 'link', name=link)
        for geometry in by_link[link]:
            _add_collision(element, geometry)
    for joint in joints:
        _add_joint(root, joint)
    _add_filters(root, _pairs_of(scene), scene)
    return _text(root)


def _text(root: Any) -> str:
    etree.indent(root)
    return f'{etree.tostring(root, encoding="unicode")}\n'


def _with_robot(scene: SceneDescription) -> SceneDescription:
    """Return a scene of one body, such as a mesh file, as that of a robot of one link."""
    if scene.robots or not len(scene.sources) == len(scene.frames) == 1:
        return scene
    (name,), (body,) = scene.sources, scene.frames
    tree = LinkTree(name, (body.name,), ())
    return replace(scene, robots=(RobotDescription(name, None, RigidTransform(), tree=tree),))


def _only_robot(scene: SceneDescription) -> RobotDescription:
    """Return the one robot of a scene; raises SceneFileError for what stands beside it."""
    if len(scene.robots) != 1 or scene.sources != (scene.robots[0].name,):
        raise SceneFileError(
            f'a URDF holds one robot, and this is {len(scene.robots)} robots with the sources '
            f'{", ".join(scene.sources) or "none"}',
            scene.file,
        )
    (robot,) = scene.robots
    tree = robot.tree
    links = set(tree.links) if tree else set()
    beside = [frame.name for frame in scene.frames if frame.name not in links]
    listed = {
        'cameras': [camera.name for camera in scene.cameras],
        'proximity rules': [rule.name for rule in scene.rules],
        'obstacle sources': [source.name for source in scene.obstacle_sources],
        'gates': [gate.in_words() for gate in scene.gates],
        'filters that wait for other sources': [str(each.where) for each in scene.awaited],
        'frames that are no links': beside,
        'first joint values': list(robot.configuration),
        'a carrier of another source': [robot.mounted_on.frame] if robot.mounted_on else [],
        'first poses of free links': _posed_free_links(robot, scene),
    }
    for what, names in listed.items():
        if names:
            raise SceneFileError(f'a URDF cannot hold {what}: {_some(names)}', scene.file)
    return robot


def _posed_free_links(robot: RobotDescription, scene: SceneDescription) -> list[str]:
    """Return the links that are held by nothing, or float, and have a first pose."""
    joints = robot.tree.joints if robot.tree else ()
    held = {joint.child for joint in joints if joint.type not in _FREE}
    return [
        frame.name
        for frame in scene.frames
        if frame.name not in held
        and not frame.welded
        and frame.X_PF is not None
        and not frame.X_PF.IsExactlyIdentity()
    ]


def _base_joint(robot: RobotDescription, scene: SceneDescription) -> tuple[UrdfJoint, ...]:
    """Return the joint that welds the root link to the world; none for a free one."""
    held = {joint.child for joint in robot.tree.joints} if robot.tree else set()
    return tuple(
        UrdfJoint('fixed', WORLD, frame.name, f'{frame.name}_weld', robot.X_WB, (1.0, 0.0, 0.0))
        for frame in scene.frames
        if frame.welded and frame.name not in held
    )


def _add_collision(link: Any, geometry: GeometryDescription) -> None:
    """Add a collision element; SceneFileError names a geometry that it cannot hold."""
    name = f'{geometry.frame}/{geometry.name}'
    others = [role.name for role in geometry.roles if role is not Role.kProximity]
    if others or Role.kProximity not in geometry.roles:
        raise geometry.where.error(
            f'{name} has {", ".join(others) or "no role"}; a URDF holds the proximity role'
        )
    collision = etree.SubElement(link, 'collision', name=geometry.name)
    _add_origin(collision, geometry.X_FG)
    properties = geometry.roles[Role.kProximity]
    assert isinstance(properties, ProximityProperties)
    try:
        _add_shape(etree.SubElement(collision, 'geometry'), geometry.shape)
        write_properties(collision, properties, _DRAKE)
    except ValueError as error:
        raise geometry.where.error(f'{name}: {error}') from None


def _add_shape(geometry: Any, shape: Shape) -> None:
    """Add the element of a shape; ValueError for a shape that a URDF cannot hold."""
    if isinstance(shape, Box):
        etree.SubElement(geometry, 'box', size=_numbers(shape.size()))
    elif isinstance(shape, tuple(_LENGTHS)):
        tag, names = _LENGTHS[type(shape)]
        etree.SubElement(
            geometry, tag, {name: _numbers([getattr(shape, name)()]) for name in names}
        )
    elif isinstance(shape, Convex | Mesh) and not isinstance(shape, HeightField):
        if shape.mesh_data() is not None:
            raise ValueError('a mesh in memory is no file, and a URDF names a file')
        file = f'file://{Path(shape.filename())}'
        mesh = etree.SubElement(geometry, 'mesh', filename=file, scale=_numbers(shape.scale3()))
        if isinstance(shape, Convex):
            etree.SubElement(mesh, f'{{{_DRAKE}}}declare_convex')
    else:
        raise ValueError(f'a URDF has no shape for a {type(shape).__name__}')


def _add_joint(root: Any, joint: UrdfJoint) -> None:
    """Add a joint, or the chain of simple joints with links between them that it stands for."""
    chain = (joint,) if joint.type in _FREE and not joint.parts else parts_of(joint)
    parent = joint.parent
    for k, part in enumerate(chain, start=1):
        child = joint.child if k == len(chain) else f'{joint.name}/link_{k}'
        if child != joint.child:
            root.insert(len(root.findall('link')), root.makeelement('link', name=child))
        _add_simple(root, part, parent, child)
        parent = child


def _add_simple(root: Any, joint: UrdfJoint, parent: str, child: str) -> None:
    unlimited = math.isinf(joint.lower) and math.isinf(joint.upper)
    kind = 'continuous' if joint.type == 'revolute' and unlimited else joint.type
    element = etree.SubElement(root, 'joint', name=joint.name, type=kind)
    etree.SubElement(element, 'parent', link=parent)
    etree.SubElement(element, 'child', link=child)
    _add_origin(element, joint.X_PJ)
    if kind == 'fixed':
        return
    etree.SubElement(element, 'axis', xyz=_numbers(joint.axis))
    limits = {'effort': '0'}
    if kind in ('revolute', 'prismatic'):
        low, high = max(joint.lower, -_UNLIMITED), min(joint.upper, _UNLIMITED)
        limits |= {'lower': _numbers([low]), 'upper': _numbers([high])}
    if math.isfinite(joint.max_speed):
        limits['velocity'] = _numbers([joint.max_speed])
    if len(limits) > 1:
        etree.SubElement(element, 'limit', {'velocity': '0', **limits})
    if joint.mimic is not None:
        numbers = {
            'multiplier': _numbers([joint.mimic.multiplier]),
            'offset': _numbers([joint.mimic.offset]),
        }
        etree.SubElement(element, 'mimic', joint=joint.mimic.joint, **numbers)


def _add_origin(element: Any, X: RigidTransform) -> None:
    if not X.IsExactlyIdentity():
        rpy = RollPitchYaw(X.rotation()).vector()
        etree.SubElement(element, 'origin', xyz=_numbers(X.translation()), rpy=_numbers(rpy))


def _numbers(values: Any) -> str:
    """Return numbers as the shortest texts that read back as the same numbers."""
    return ' '.join(repr(float(value) + 0.0) for value in values)


def _add_filters(root: Any, candidates: _Pairs, scene: SceneDescription) -> None:
    """Add a group for each two links whose pairs are filtered, and not by the joints alone.

    Raises SceneFileError for pairs that no group of links can filter, and for pairs that are
    candidates although a joint filters them in every URDF.
    """
    written = _written_pairs(root, scene)
    if lost := sorted(map(sorted, candidates - written)):
        raise SceneFileError(
            'a URDF filters pairs that are reported here, as of links at one joint: '
            f'{_pairs(lost)}',
            scene.file,
        )
    for pair in sorted({tuple(sorted(link for link, _ in p)) for p in written - candidates}):
        name = ' - '.join(pair)
        tag = f'{{{_DRAKE}}}collision_filter_group'
        group = etree.SubElement(root, tag, name=name)
        for link in pair:
            etree.SubElement(group, f'{{{_DRAKE}}}member', link=link)
        etree.SubElement(group, f'{{{_DRAKE}}}ignored_collision_filter_group', name=name)
    if differing := sorted(map(sorted, candidates ^ _written_pairs(root, scene))):
        raise SceneFileError(
            f'a URDF filters pairs of whole links, and not single ones: {_pairs(differing)}',
            scene.file,
        )


def _written_pairs(root: Any, scene: SceneDescription) -> _Pairs:
    """Return the candidate pairs of the text as it is read."""
    name = scene.robots[0].name
    parts = read_urdf(
        *(_text(root).encode(), '<urdf>', name, Path.cwd()), ResourceResolver(), RobotOptions()
    )
    described = SceneDescription(
        '<urdf>',
        sources=(name,),
        frames=parts.frames,
        geometries=parts.geometries,
        filters=parts.filters,
    )
    return _pairs_of(described)


def _pairs_of(scene: SceneDescription) -> _Pairs:
    """Return the candidate pairs of a scene, each geometry by its link and its name."""
    scene_graph = SceneGraph()
    loaded = register(scene_graph, scene)
    names = {id: (frame, name) for (_, frame, name), id in loaded.geometries.items()}
    manager = scene_graph.collision_filter_manager()
    return {
        frozenset((names[a], names[b]))
        for a, b in combinations(names, 2)
        if not manager.explain(a, b)
    }


def _pairs(pairs: list[list[tuple[str, str]]]) -> str:
    return _some([' and '.join('/'.join(name) for name in pair) for pair in pairs])


def _some(names: list[str]) -> str:
    return ', '.join(names[:_SHOWN]) + ', ...' * (len(names) > _SHOWN)
