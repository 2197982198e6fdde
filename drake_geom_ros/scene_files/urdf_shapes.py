"""Shapes of URDF collision elements, including those that Drake adds to the format.

Drake adds ``<drake:capsule radius= length=>``, ``<drake:ellipsoid a= b= c=>`` and, inside a
``<mesh>``, ``<drake:declare_convex/>``; ``<capsule>`` is also a shape of newer URDF.
"""

from pathlib import Path
from typing import Any

from drake_geom_ros.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, Mesh, Shape, Sphere
from drake_geom_ros.scene_files.resources import ResourceResolver
from drake_geom_ros.scene_files.xml_tree import local_name, numbers

# Beside a mesh instead of in it, as one of Drake's models has it, it says nothing, as in Drake.
_DECLARATION = 'declare_convex'
KNOWN_SHAPES = ('box', 'capsule', 'cylinder', 'ellipsoid', 'mesh', 'sphere')


def shape_of(collision: Any, folder: Path, resolver: ResourceResolver) -> Shape:
    """Return the shape of a collision element; mesh paths count from ``folder``.

    Raises ValueError or RuntimeError, which name no line, for no shape, several or an unknown
    one, for bad dimensions and for a mesh that cannot be found.
    """
    geometry = collision.find('geometry')
    shapes = [] if geometry is None else [e for e in geometry if local_name(e) != _DECLARATION]
    if len(shapes) != 1:
        raise ValueError('missing <geometry> with one shape')
    shape = shapes[0]
    kind = local_name(shape)
    if kind == 'mesh':
        return _mesh(shape, folder, resolver)
    if kind == 'sphere':
        return Sphere(*numbers(shape, 'radius', 1))
    if kind == 'box':
        return Box(*numbers(shape, 'size', 3))
    if kind == 'ellipsoid':
        return Ellipsoid(*(numbers(shape, axis, 1)[0] for axis in 'abc'))
    if kind in ('capsule', 'cylinder'):
        make = Cylinder if kind == 'cylinder' else Capsule
        return make(*(numbers(shape, name, 1)[0] for name in ('radius', 'length')))
    advice = '; give a cone as a mesh, whose hull it is' if kind == 'cone' else ''
    raise ValueError(f'unknown shape <{kind}>; known are {", ".join(KNOWN_SHAPES)}{advice}')


def _mesh(element: Any, folder: Path, resolver: ResourceResolver) -> Shape:
    filename = element.get('filename')
    if not filename:
        raise ValueError('mesh has no attribute `filename`')
    path = str(resolver.resolve(filename, folder))
    convex = any(local_name(child) == _DECLARATION for child in element)
    scales = element.get('scale', '')
    uniform = len(scales.split()) == 1 and ',' not in scales
    scale = numbers(element, 'scale', 1 if uniform else 3, '1 1 1')
    return (Convex if convex else Mesh)(path, scale[0] if uniform else scale)
