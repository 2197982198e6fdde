"""URDF -> frames, geometries and filters of one robot.

Each link becomes a frame of the robot's source, whatever joint holds it. All of these frames
have the world as parent, because forward kinematics gives X_WF, and a stream of such poses can
then drop or add a link without bending the others. A link called ``world`` is the world itself, as
in Drake: it becomes no frame. Collision elements become geometries with the proximity role; visual
elements are left alone.

Read are links, joints and collision elements, and no more: a geometry service has no use for
masses, limits and visuals, and a library that reads those as well (yourdfpy) brings trimesh and
FCL into a process whose scene has no mesh, 0.7 s and 60 MB.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drake_geom_ros.geometry import Mesh, ProximityProperties, Role
from drake_geom_ros.math import RigidTransform, RollPitchYaw
from drake_geom_ros.scene_files import urdf_filters, urdf_shapes
from drake_geom_ros.scene_files.description import (
    WORLD,
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    RobotOptions,
)
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.urdf_filters import Joint, moved_links
from drake_geom_ros.scene_files.xml_tree import attribute, numbers, place_of, read_robot_xml


@dataclass(frozen=True)
class RobotParts:
    """What a URDF describes; ``warnings`` are what it says that is not understood."""

    frames: tuple[FrameDescription, ...]
    geometries: tuple[GeometryDescription, ...]
    filters: tuple[FilterDescription, ...]
    warnings: tuple[str, ...] = ()

    @property
    def link_names(self) -> list[str]:
        """The links in the order of the file."""
        return [frame.name for frame in self.frames]


def robot_name(data: bytes, file: str) -> str:
    """Return the name that a URDF gives its robot."""
    return attribute(read_robot_xml(data, file), 'name', file)


def read_urdf(
    data: bytes,
    file: str,
    source: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> RobotParts:
    """Return the parts of a robot as those of ``source``; mesh paths count from ``folder``.

    The n-th geometry of a link is named as its collision element, or ``collision_n`` (from 0)
    where that has no name or one that an earlier element of the link has.
    Raises SceneFileError, with the line, for what is not a URDF, links that are there twice or
    not at all, shapes that are not known or have bad dimensions, and missing mesh files.
    """
    root = read_robot_xml(data, file)
    attribute(root, 'name', file)
    links = _links(root, file)
    joints = [_joint(element, links, file) for element in root.findall('joint')]
    held = [*joints, *urdf_filters.drakes_joints(root, links, file)]
    groups, warnings = urdf_filters.read_groups(root, file, source)
    moved, welded = moved_links(held), urdf_filters.welded_links(held, options)
    frames = []
    geometries: list[GeometryDescription] = []
    for name, element in links.items():
        if name == WORLD:
            _check_world(element, file)
            continue
        static = False if name in moved else None
        where = place_of(element, file)
        frames.append(
            FrameDescription(source, name, static=static, where=where, welded=name in welded)
        )
        geometries += _link_geometries(element, name, file, source, folder, resolver, options)
    with_geometry = {geometry.frame for geometry in geometries}
    filters: tuple[FilterDescription, ...] = (
        *urdf_filters.adjacent_cliques(held, with_geometry, source, options),
        *urdf_filters.self_cliques(with_geometry, source, options),
        *groups,
    )
    return RobotParts(tuple(frames), tuple(geometries), filters, warnings)


def _links(root: Any, file: str) -> dict[str, Any]:
    """Return the link elements by name; refuse missing names, and links that are there twice."""
    links: dict[str, Any] = {}
    for element in root.findall('link'):
        name = attribute(element, 'name', file)
        if name in links:
            first = links[name].sourceline
            raise place_of(element, file).error(f'link {name!r} is listed twice, see line {first}')
        links[name] = element
    return links


def _check_world(element: Any, file: str) -> None:
    """Refuse a link called as the world frame is that has shapes: whose they are is not clear."""
    if element.find('collision') is not None:
        raise place_of(element, file).error(
            f'the link {WORLD!r} is the world frame and cannot have collision elements; make them '
            'anchored geometries of the scene file, or rename the link'
        )


def _joint(element: Any, links: Mapping[str, Any], file: str) -> Joint:
    """Return what a joint holds together; refuse one to a link that is not there."""
    attribute(element, 'name', file)
    ends = []
    for end in ('parent', 'child'):
        child = element.find(end)
        if child is None:
            raise place_of(element, file).error(f'missing <{end} link="..."/>')
        link = attribute(child, 'link', file)
        if link not in links:
            raise place_of(child, file).error(f'link {link!r} is not in the file')
        ends.append(link)
    return Joint(attribute(element, 'type', file), *ends)


def _link_geometries(
    link: Any,
    frame: str,
    file: str,
    source: str,
    folder: Path,
    resolver: ResourceResolver,
    options: RobotOptions,
) -> Iterator[GeometryDescription]:
    names: set[str] = set()
    for index, element in enumerate(link.findall('collision')):
        place = place_of(element, file)
        try:
            shape = urdf_shapes.shape_of(element, folder, resolver)
            X_LG = _pose(element.find('origin'))
        except (ValueError, RuntimeError) as error:
            raise place.error(str(error)) from error
        name = (element.get('name') or '').strip(' \t')
        if not name or name in names:
            name = f'{name or "collision"}_{index}'
        names.add(name)
        properties = ProximityProperties()
        if isinstance(shape, Mesh) and options.is_solid(frame, name):
            properties.AddProperty('mesh', 'solid', True)
        roles = {Role.kProximity: properties}
        yield GeometryDescription(source, frame, name, shape, X_LG, roles, place)


def _pose(origin: Any) -> RigidTransform:
    """Return the pose that an ``<origin>``, None where there is none, stands for."""
    if origin is None:
        return RigidTransform()
    xyz, rpy = (numbers(origin, name, 3, '0 0 0') for name in ('xyz', 'rpy'))
    if not all(map(math.isfinite, (*xyz, *rpy))):
        raise ValueError('origin: xyz and rpy must be finite numbers')
    return RigidTransform(RollPitchYaw(rpy).ToRotationMatrix(), xyz)
