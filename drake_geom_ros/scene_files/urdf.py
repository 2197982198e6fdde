"""Frames, geometries and filters of one robot from its URDF.

Each link becomes a frame of the robot's source, whatever joint holds it. All of these frames
have the world as parent, because forward kinematics gives X_WF, and a stream of such poses can
then omit or add a link without changing the others. A link named ``world`` is the world itself,
as in Drake, and becomes no frame; its geometries are anchored. Collision elements become
geometries with the proximity role.

Only links, joints and collision elements are read; masses and visuals change no answer.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from drake_geom_ros.geometry import Mesh, Role
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import urdf_filters, urdf_shapes
from drake_geom_ros.scene_files.description import (
    WORLD,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    RobotOptions,
)
from drake_geom_ros.scene_files.drake_names import drake_names, set_drake_name
from drake_geom_ros.scene_files.flat_meshes import with_flat_meshes
from drake_geom_ros.scene_files.link_tree import LinkTree
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.robot_parts import RobotParts, is_visual_only, visual_only_warning
from drake_geom_ros.scene_files.urdf_filters import moved_links
from drake_geom_ros.scene_files.urdf_joint_checks import warnings_about
from drake_geom_ros.scene_files.urdf_poses import pose_of
from drake_geom_ros.scene_files.urdf_proximity import proximity_properties_of
from drake_geom_ros.scene_files.urdf_tree import read_joints, read_links
from drake_geom_ros.scene_files.urdf_vocabulary import check_vocabulary
from drake_geom_ros.scene_files.xml_tree import (
    attribute,
    encoding_warning,
    local_name,
    numbers,
    place_of,
    prefix_warning,
    robot_xml,
)

_IMPLICIT_WORLD = (
    f'the parent {WORLD!r} of a joint is no link of the file: it is read as the world, as in '
    'Drake and Gazebo; urdfdom, and with it robot_state_publisher and MoveIt, refuses the robot'
)
_UNDRIVEN = 'no joint value moves a curvilinear joint: send poses of {!r} and the links below it'
_NO_SHAPES = 'the robot {!r} has no <collision> elements: no query sees anything of it'


def read_urdf(
    data: bytes,
    file: str,
    source: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> RobotParts:
    """Return the parts of a robot, owned by ``source``; mesh paths count from ``folder``.

    The n-th geometry of a link has the name of its collision element, or ``collision_n`` (from 0)
    if that has no name or repeats one of the link; look-ups also find it by Drake's name for it. A
    warning names links with a visual and
    without a collision element. Raises SceneFileError, with the line, for

    - text that is not a URDF, or has no links;
    - links and joints that are duplicate, missing or form no tree;
    - unknown shapes, bad dimensions and missing mesh files;
    - elements whose meaning is certainly not what would be read.
    """
    with robot_xml(data, file) as root:
        return _parts_of(root, data, file, source, folder, resolver, options)


def _parts_of(
    root: Any,
    data: bytes,
    file: str,
    source: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> RobotParts:
    """Return the parts of a robot by its root element."""
    robot = attribute(root, 'name', file)
    warnings = encoding_warning(data, root, file) + prefix_warning(root, file)
    warnings += check_vocabulary(root, file)
    links = read_links(root, file)
    joints = read_joints(root, links, file)
    warnings += tuple(warnings_about(root, joints))
    undriven = urdf_filters.undriven_joints(root, links, file)
    held = [*joints, *undriven]
    groups, of_groups = urdf_filters.read_groups(root, file, source)
    warnings += of_groups
    if WORLD in links and links[WORLD].getparent() is None:
        warnings += (str(place_of(root, file).error(_IMPLICIT_WORLD)),)
    for joint in undriven:
        warnings += (str(place_of(root, file).error(_UNDRIVEN.format(joint.child))),)
    moved, welded = moved_links(held), urdf_filters.welded_links(held, options)
    frames = []
    listed: list[GeometryDescription] = []
    for name, element in links.items():
        if name == WORLD:
            of_world = _link_geometries(element, name, file, source, folder, resolver, options)
            listed += of_world
            continue
        static = False if name in moved else None
        where = place_of(element, file)
        frames.append(
            FrameDescription(source, name, static=static, where=where, welded=name in welded)
        )
        listed += _link_geometries(element, name, file, source, folder, resolver, options)
    geometries, of_flat = with_flat_meshes(listed, options, place_of(root, file))
    warnings += of_flat
    if below := [joint for joint in joints if joint.child == WORLD]:
        raise below[0].where.error(f'the child {WORLD!r} is the world frame, which nothing holds')
    # As in Drake, a joint to the world filters no pair.
    with_geometry = {geometry.frame for geometry in geometries} - {WORLD}
    filters: tuple[FilterDescription, ...] = (
        *urdf_filters.adjacent_cliques(held, with_geometry, source, options),
        *urdf_filters.self_cliques(with_geometry, source, options),
        *groups,
    )
    if not geometries:
        warnings += (str(place_of(root, file).error(_NO_SHAPES.format(source))),)
    else:
        warnings += visual_only_warning(_visual_only(links), len(links), place_of(root, file))
    tree = LinkTree(robot, tuple(links), tuple(joints))
    offsets = _offsets(root, links, file)
    return RobotParts(tuple(frames), geometries, filters, tree, warnings, offsets)


def _visual_only(links: Mapping[str, Any]) -> list[str]:
    """Return the links with a visual and without a collision element."""
    return [name for name, link in links.items() if name != WORLD and is_visual_only(link)]


def _offsets(
    root: Any, links: Mapping[str, Any], file: str
) -> dict[str, tuple[str, RigidTransform]]:
    """Return Drake's ``<frame name= link= xyz= rpy=>`` elements that name a link, by name."""
    offsets = {}
    for element in root:
        if local_name(element) == 'frame' and element.get('link') in links:
            xyz, rpy = (numbers(element, name, 3, '0 0 0') for name in ('xyz', 'rpy'))
            X_LF = RigidTransform(RollPitchYaw(rpy).ToRotationMatrix(), xyz)
            offsets[attribute(element, 'name', file)] = (element.get('link'), X_LF)
    return offsets


def _link_geometries(
    link: Any,
    frame: str,
    file: str,
    source: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> Iterator[GeometryDescription]:
    elements = link.findall('collision')
    named = [(element.get('name') or '').strip(' \t') for element in elements]
    names = _unique(named)
    parts = []
    for element in elements:
        try:
            shape = urdf_shapes.shape_of(element, folder, resolver)
            parts.append((shape, pose_of(element), proximity_properties_of(element)))
        except (ValueError, RuntimeError) as error:
            raise place_of(element, file).error(str(error)) from error
    of_drake = drake_names(named, [type(shape).__name__ for shape, *_ in parts])
    for index, (shape, X_LG, properties) in enumerate(parts):
        name, place = names[index], place_of(elements[index], file)
        if of_drake[index] not in names:
            set_drake_name(properties, of_drake[index])
        if isinstance(shape, Mesh) and options.is_solid(frame, name):
            properties.AddProperty('mesh', 'solid', True)
        if padding := options.padding(frame, name):
            properties.AddProperty('proximity', 'padding', padding)
        roles = {Role.kProximity: properties}
        yield GeometryDescription(source, frame, name, shape, X_LG, roles, place)


def _unique(named: Sequence[str]) -> list[str]:
    """Return the names of a link's collision elements, with numbers where they lack one."""
    names: list[str] = []
    for index, name in enumerate(named):
        is_own = name and name not in names
        names.append(name if is_own else f'{name or "collision"}_{index}')
    return names
