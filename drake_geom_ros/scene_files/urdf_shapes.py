"""Shapes of URDF collision elements, those that Drake adds to the format included.

Drake adds ``<drake:capsule radius= length=>``, ``<drake:ellipsoid a= b= c=>`` and, inside a
``<mesh>``, ``<drake:declare_convex/>``; ``<capsule>`` is also a shape of newer URDF. The URDF
library knows none of these, so it is given a stand-in with the same numbers in its place.
"""

from pathlib import Path
from typing import Any

from lxml import etree

from drake_geom_ros.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, Mesh, Shape, Sphere
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.xml_tree import attribute, local_name, place_of

KNOWN_SHAPES = ('box', 'capsule', 'cylinder', 'ellipsoid', 'mesh', 'sphere')


def put_stand_ins(root: Any, file: str) -> None:
    """Replace capsules by cylinders and ellipsoids by boxes, and drop unread visual elements.

    Raises SceneFileError where a collision element has no shape, several, or an unknown one.
    """
    for link in root.findall('link'):
        for visual in link.findall('visual'):
            link.remove(visual)
        for collision in link.findall('collision'):
            geometry = collision.find('geometry')
            if geometry is None or len(geometry) != 1:
                raise place_of(collision, file).error('misses <geometry> with one shape in it')
            shape = geometry[0]
            kind = local_name(shape)
            if kind not in KNOWN_SHAPES:
                known = ', '.join(KNOWN_SHAPES)
                raise place_of(shape, file).error(f'unknown shape <{kind}>; known are {known}')
            if kind == 'capsule':
                geometry[0] = etree.Element('cylinder', shape.attrib)
            elif kind == 'ellipsoid':
                size = ' '.join(attribute(shape, axis, file) for axis in 'abc')
                geometry[0] = etree.Element('box', size=size)


def shape_of(element: Any, geometry: Any, folder: Path, resolver: ResourceResolver) -> Shape:
    """Return the shape of a collision element, which the library read as ``geometry``.

    Raises ValueError or RuntimeError for bad dimensions and for a mesh that cannot be found.
    """
    shape = element.find('geometry')[0]
    kind = local_name(shape)
    if kind == 'mesh':
        return _mesh(shape, geometry.mesh, folder, resolver)
    if kind == 'sphere':
        return Sphere(geometry.sphere.radius)
    if kind in ('box', 'ellipsoid'):
        if len(geometry.box.size) != 3:
            raise ValueError(f'box size {geometry.box.size.tolist()} must have 3 numbers')
        sizes = map(float, geometry.box.size)
        return Box(*sizes) if kind == 'box' else Ellipsoid(*sizes)
    cylinder = geometry.cylinder
    return (Cylinder if kind == 'cylinder' else Capsule)(cylinder.radius, cylinder.length)


def _mesh(element: Any, mesh: Any, folder: Path, resolver: ResourceResolver) -> Shape:
    if not mesh.filename:
        raise ValueError('mesh misses the attribute `filename`')
    path = str(resolver.resolve(mesh.filename, folder))
    convex = any(local_name(child) == 'declare_convex' for child in element)
    return (Convex if convex else Mesh)(path, 1.0 if mesh.scale is None else mesh.scale)
