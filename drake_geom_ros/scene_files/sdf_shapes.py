"""Shapes of SDFormat, including those that Drake adds to the format."""

from typing import Any

from drake_geom_ros.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)
from drake_geom_ros.geometry.shapes.extrusion import extruded
from drake_geom_ros.geometry.shapes.submeshes import submesh
from drake_geom_ros.math import RigidTransform
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.sdf_elements import SdfFile, flag_in, numbers_in, text_of
from drake_geom_ros.scene_files.sdf_heightmaps import height_field_of
from drake_geom_ros.scene_files.xml_tree import local_name

KNOWN_SHAPES = (
    'box',
    'capsule',
    'cylinder',
    'ellipsoid',
    'empty',
    'heightmap',
    'mesh',
    'plane',
    'polyline',
    'sphere',
)
_HOW = {
    'image': 'give its boxes, or a mesh',
    'cone': 'give it as a mesh, whose hull is the cone',
}


def shape_of(
    geometry: Any, file: SdfFile, resolver: ResourceResolver
) -> tuple[Shape, RigidTransform] | None:
    """Return the shape S of a geometry element and its pose X_GS; None if it is ``<empty>``.

    Raises ValueError or RuntimeError, which name no line, for no shape, several or an unknown
    one, for bad dimensions and for a mesh that cannot be found.
    """
    if geometry is None or len(geometry) != 1:
        raise ValueError('missing <geometry> with one shape')
    shape = geometry[0]
    kind = local_name(shape)
    stays = RigidTransform()
    if kind == 'empty':
        return None
    if kind == 'mesh':
        return _mesh(shape, file, resolver), stays
    if kind == 'plane':
        return HalfSpace(), HalfSpace.MakePose(numbers_in(shape, 'normal', 3, '0 0 1'), (0, 0, 0))
    if kind == 'sphere':
        return Sphere(*numbers_in(shape, 'radius', 1)), stays
    if kind == 'box':
        return Box(*numbers_in(shape, 'size', 3)), stays
    if kind == 'ellipsoid':
        if shape.find('radii') is not None:
            return Ellipsoid(*numbers_in(shape, 'radii', 3)), stays
        return Ellipsoid(*(numbers_in(shape, axis, 1)[0] for axis in 'abc')), stays
    if kind in ('capsule', 'cylinder'):
        make = Cylinder if kind == 'cylinder' else Capsule
        return make(*(numbers_in(shape, name, 1)[0] for name in ('radius', 'length'))), stays
    if kind == 'polyline':
        return _polyline(shape), stays
    if kind == 'heightmap':
        return height_field_of(shape, file, resolver), _position_of(shape)
    advice = f'; {_HOW[kind]}' if kind in _HOW else ''
    raise ValueError(f'the shape <{kind}> is not read{advice}; read are {", ".join(KNOWN_SHAPES)}')


def _position_of(heightmap: Any) -> RigidTransform:
    return RigidTransform(numbers_in(heightmap, 'pos', 3, '0 0 0'))


def _polyline(element: Any) -> Mesh:
    """Return the mesh of an outline that is extruded along z, from 0 to its height."""
    points = [numbers_in(each, '', 2) for each in element.findall('point')]
    return Mesh.FromMeshData(extruded(points, *numbers_in(element, 'height', 1)))


def _mesh(element: Any, file: SdfFile, resolver: ResourceResolver) -> Shape:
    uri = text_of(element, 'uri')
    if not uri:
        raise ValueError('<mesh> has no <uri>')
    path = str(resolver.resolve(uri, file.folder))
    scale = numbers_in(element, 'scale', 3, '1 1 1')
    convex = element.get('optimization') in ('convex_hull',) or any(
        local_name(child) == 'declare_convex' for child in element
    )
    kind = Convex if convex else Mesh
    part = element.find('submesh')
    if part is None:
        return kind(path, scale)
    name = text_of(part, 'name')
    if not name:
        raise ValueError('<submesh> has no <name>')
    return kind.FromMeshData(submesh(path, name, flag_in(part, 'center')), scale)


def is_extruded(geometry: Any) -> bool:
    """Return whether a geometry element is a ``<polyline>``, which is a solid."""
    return geometry is not None and geometry.find('polyline') is not None
