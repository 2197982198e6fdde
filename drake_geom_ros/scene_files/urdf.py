"""URDF -> frames, geometries and filters of one robot.

Each link becomes a frame of the robot's source, whatever joint holds it. All of these frames
have the world as parent, because forward kinematics gives X_WF, and a stream of such poses can
then drop or add a link without bending the others. Collision elements become geometries with
the proximity role; visual elements are left alone.

yourdfpy reads the file. What it does not know is taken from the XML tree: Drake's shapes
(``urdf_shapes``), Drake's ``<collision_filter_group>`` (``urdf_filters``), and line numbers.
"""

import copy
import io
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from lxml import etree

from drake_geom_ros.geometry import ProximityProperties, Role
from drake_geom_ros.math import RigidTransform, RotationMatrix
from drake_geom_ros.scene_files import urdf_filters, urdf_shapes
from drake_geom_ros.scene_files.description import (
    FilterDescription,
    FrameDescription,
    GeometryDescription,
    RobotOptions,
)
from drake_geom_ros.scene_files.errors import SceneFileError
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.xml_tree import attribute, place_of, read_robot_xml

# What yourdfpy, which checks little, lets through from numpy, float() and missing elements.
_LIBRARY_ERRORS = (ValueError, TypeError, KeyError, IndexError, AttributeError)


@dataclass(frozen=True)
class RobotParts:
    """What a URDF describes."""

    frames: tuple[FrameDescription, ...]
    geometries: tuple[GeometryDescription, ...]
    filters: tuple[FilterDescription, ...]

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
    _check_links(root, file)
    robot = _library_robot(root, file)
    frames = []
    geometries: list[GeometryDescription] = []
    for element, link in zip(root.findall('link'), robot.links, strict=True):
        frames.append(FrameDescription(source, link.name, where=place_of(element, file)))
        geometries += _link_geometries(element, link, file, source, folder, resolver)
    with_geometry = {geometry.frame for geometry in geometries}
    filters: tuple[FilterDescription, ...] = (
        *urdf_filters.adjacent_cliques(robot.joints, with_geometry, source, options),
        *urdf_filters.self_cliques(with_geometry, source, options),
        *urdf_filters.read_groups(root, file, source),
    )
    return RobotParts(tuple(frames), tuple(geometries), filters)


def _check_links(root: Any, file: str) -> None:
    """Refuse missing names, links that are there twice, and joints to links that are not there."""
    attribute(root, 'name', file)
    lines: dict[str, int] = {}
    for element in root.findall('link'):
        name = attribute(element, 'name', file)
        if name in lines:
            first = lines[name]
            raise place_of(element, file).error(f'link {name!r} is there twice, see line {first}')
        lines[name] = element.sourceline
    for joint in root.findall('joint'):
        for end in ('parent', 'child'):
            element = joint.find(end)
            if element is None:
                raise place_of(joint, file).error(f'misses <{end} link="..."/>')
            link = attribute(element, 'link', file)
            if link not in lines:
                raise place_of(element, file).error(f'link {link!r} is not in the file')


def _library_robot(root: Any, file: str) -> Any:
    """Return yourdfpy's robot; meshes are not loaded."""
    prepared = copy.deepcopy(root)
    urdf_shapes.put_stand_ins(prepared, file)
    try:
        return _parse(prepared)
    except _LIBRARY_ERRORS as error:
        raise _blame(root, prepared, file, error) from error


def _parse(root: Any) -> Any:
    # It brings trimesh along, 2 s that a scene without robots does not wait for.
    import yourdfpy

    text = io.BytesIO(etree.tostring(root, encoding='utf-8'))
    with np.errstate(invalid='ignore'):  # infinity in an origin, which _pose refuses
        return yourdfpy.URDF.load(text, build_scene_graph=False, load_meshes=False).robot


def _blame(root: Any, prepared: Any, file: str, error: Exception) -> SceneFileError:
    """Return an error that names the first element that the library cannot read on its own."""
    culprit, fault = root, error
    for original, element in zip(root, prepared, strict=True):
        alone = etree.Element('robot', name='alone')
        alone.append(copy.deepcopy(element))
        try:
            _parse(alone)
        except _LIBRARY_ERRORS as its_error:
            culprit, fault = original, its_error
            break
    reason = f'misses {fault}' if isinstance(fault, KeyError) else f'{fault}'
    return place_of(culprit, file).error(f'cannot be read: {reason}')


def _link_geometries(
    element: Any, link: Any, file: str, source: str, folder: Path, resolver: ResourceResolver
) -> Iterator[GeometryDescription]:
    names: set[str] = set()
    collisions = zip(element.findall('collision'), link.collisions, strict=True)
    for index, (collision_element, collision) in enumerate(collisions):
        place = place_of(collision_element, file)
        try:
            shape = urdf_shapes.shape_of(collision_element, collision.geometry, folder, resolver)
            X_LG = _pose(collision.origin)
        except (ValueError, RuntimeError) as error:
            raise place.error(str(error)) from error
        name = (collision.name or '').strip(' \t')
        if not name or name in names:
            name = f'{name or "collision"}_{index}'
        names.add(name)
        roles = {Role.kProximity: ProximityProperties()}
        yield GeometryDescription(source, link.name, name, shape, X_LG, roles, place)


def _pose(origin: Any) -> RigidTransform:
    """Return the pose that a URDF origin, a matrix (4, 4) or None, stands for."""
    if origin is None:
        return RigidTransform()
    if not np.isfinite(origin).all():
        raise ValueError('origin: xyz and rpy must be finite numbers')
    return RigidTransform(RotationMatrix(origin[:3, :3]), origin[:3, 3])
