"""Collada files (.dae): the triangles of their scene in metres, by their ``<unit>``.

``<up_axis>`` is not applied, as in RViz, since robots in use were modelled to look right there.
Deformations of meshes, dangling references and references to other files are errors.

trimesh reads Collada by pycollada, which rounds all numbers and poses to single precision, takes
NaN for 0 and leaves out what it does not understand, so this file does not use it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from xml.etree import ElementTree

import numpy as np

from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh, Pieces
from drake_geom_ros.geometry.meshes._polygons import cut_faces, fan, strip
from drake_geom_ros.math.array_types import Floats, Indices

Element = ElementTree.Element
MOST_INSTANCES = 100_000  # nodes that name one another multiply


def parse_dae(data: bytes) -> ParsedMesh:
    """Return the mesh of a file's scene, each geometry at the pose of its nodes.

    Raises ValueError, or another error for a document of another structure.
    """
    root = ElementTree.fromstring(data)
    for element in root.iter():
        element.tag = element.tag.rpartition('}')[2]
    if root.tag != 'COLLADA':
        raise ValueError(f'<{root.tag}> is no Collada file')
    metres = _unit(root)
    reader = _DaeReader(root)
    vertices, triangles = reader.mesh()
    remarks = [] if metres == 1.0 else [f'lengths are times {metres:g} m by its <unit>']
    axis = root.findtext('asset/up_axis', 'Z_UP').strip()
    if axis != 'Z_UP':
        remarks.append(f'its <up_axis> {axis} is not applied, as in RViz')
    parts = reader.parts()
    return ParsedMesh(vertices * metres, triangles, None, tuple(remarks), parts=parts)


def _unit(root: Element) -> float:
    """Return the length [m] of a file's unit."""
    units = [asset.find('unit') for asset in root.iter('asset')]
    metres = {float(unit.get('meter', '1')) for unit in units if unit is not None} or {1.0}
    if len(metres) > 1 or not all(0.0 < metre < math.inf for metre in metres):
        raise ValueError(f'<unit meter> {sorted(metres)}: one length above 0 is read')
    return metres.pop()


class _DaeReader:
    """Reads the scene of one document."""

    def __init__(self, root: Element) -> None:
        self._root = root
        self._by_id = {each.get('id'): each for each in root.iter() if each.get('id')}
        self._read: dict[str, list[tuple[Floats, Indices]]] = {}
        self._pieces = Pieces()
        self._instances = 0

    def mesh(self) -> tuple[Floats, Indices]:
        """Return vertices (n, 3), in units of the file, and triangles (m, 3)."""
        scene = self._root.find('scene/instance_visual_scene')
        if scene is None:
            raise ValueError('it has no <scene> with an <instance_visual_scene>')
        self._walk(self._target(scene.get('url')), np.eye(4), ())
        return self._pieces.all()

    def parts(self) -> dict[str, Indices]:
        """Return the rows of the triangles of nodes that have a name."""
        return self._pieces.parts()

    def _target(self, url: str | None) -> Element:
        """Return the element that a reference within the file names."""
        element = self._by_id.get((url or '').removeprefix('#'))
        if element is None or not (url or '').startswith('#'):
            raise ValueError(f'{url!r} names nothing in it; other files are not opened')
        return element

    def _walk(self, node: Element, T_FN: Floats, above: tuple[Element, ...]) -> None:
        """Add the geometries of a node and its descendants, at their poses in the file."""
        self._instances += 1
        if node in above or self._instances > MOST_INSTANCES:
            raise ValueError(f'<node id={node.get("id")!r}> is in itself, or there are too many')
        for child in node:
            if child.tag == 'node':
                self._walk(child, T_FN @ _transform(child), (*above, node))
            elif child.tag == 'instance_node':
                target = self._target(child.get('url'))
                self._walk(target, T_FN @ _transform(target), (*above, node))
            elif child.tag == 'instance_geometry':
                url = child.get('url', '')
                if url not in self._read:
                    self._read[url] = list(self._geometry(self._target(url)))
                for vertices, triangles in self._read[url]:
                    self._pieces.add(T_FN, vertices, triangles, node.get('name', ''))
            elif child.tag == 'instance_controller':
                raise ValueError(
                    f'{child.get("url")!r} is bent by a skin or morph targets; bake its pose '
                    'into the mesh'
                )

    def _geometry(self, geometry: Element) -> Iterator[tuple[Floats, Indices]]:
        """Yield the vertices and triangles of a geometry, for each of its primitives."""
        mesh = geometry.find('mesh')
        if mesh is None:
            kinds = ', '.join(f'<{child.tag}>' for child in geometry)
            raise ValueError(f'<geometry id={geometry.get("id")!r}> is {kinds}; <mesh> is read')
        for primitive in mesh:
            inputs = primitive.findall('input')
            vertex_input = next(
                (each for each in inputs if each.get('semantic') == 'VERTEX'), None
            )
            if vertex_input is None:
                continue
            positions = self._positions(self._target(vertex_input.get('source')))
            stride = 1 + max(int(each.get('offset', '0')) for each in inputs)
            first = int(vertex_input.get('offset', '0'))
            yield positions, _triangles(primitive, stride, first, positions)

    def _positions(self, vertices: Element) -> Floats:
        """Return the positions (n, 3) that a <vertices> names."""
        position_input = vertices.find("input[@semantic='POSITION']")
        if position_input is None:
            raise ValueError(f'<vertices id={vertices.get("id")!r}> has no POSITION')
        source = self._target(position_input.get('source'))
        accessor = source.find('technique_common/accessor')
        if accessor is None:
            raise ValueError(f'<source id={source.get("id")!r}> has no <accessor>')
        numbers = np.array((self._target(accessor.get('source')).text or '').split(), np.float64)
        count, stride = int(accessor.get('count', '0')), int(accessor.get('stride', '1'))
        start = int(accessor.get('offset', '0'))
        if stride < 3 or start < 0 or count < 0 or start + count * stride > len(numbers):
            raise ValueError(
                f'<source id={source.get("id")!r}> tells of {count} positions of {stride} numbers '
                f'and has {len(numbers)} numbers'
            )
        return numbers[start : start + count * stride].reshape(count, stride)[:, :3]


def _triangles(primitive: Element, stride: int, first: int, positions: Floats) -> Indices:
    """Return the triangles (m, 3) of a primitive; its corners are ``stride`` numbers each."""
    if primitive.find('ph') is not None:
        raise ValueError('it has polygons with holes; cut them into triangles')
    loops = []
    for p in primitive.findall('p'):
        numbers = np.array((p.text or '').split(), dtype=np.int64)
        if len(numbers) % stride:
            raise ValueError(f'a <p> of <{primitive.tag}> has {len(numbers)} numbers')
        loops.append(numbers.reshape(-1, stride)[:, first])
    none = np.zeros((0, 3), dtype=np.int64)
    corners = np.concatenate([none[:, 0], *loops])
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(positions):
        raise ValueError(f'<{primitive.tag}> has the vertex {corners.max()} of {len(positions)}')
    if primitive.tag == 'tristrips':
        return np.concatenate([none, *map(strip, loops)])
    if primitive.tag == 'trifans':
        return np.concatenate([none, *map(fan, loops)])
    if primitive.tag not in ('triangles', 'polylist', 'polygons'):
        return none  # lines
    counts = np.array([len(loop) for loop in loops], dtype=np.int64)
    stated_count = int(primitive.get('count', len(counts)))
    if primitive.tag == 'triangles':
        counts = np.full(stated_count, 3)
    elif primitive.tag == 'polylist':
        counts = np.array((primitive.findtext('vcount') or '').split(), dtype=np.int64)
    if counts.sum() != len(corners) or len(counts) != stated_count:
        raise ValueError(
            f'<{primitive.tag}> tells of {stated_count} faces of {counts.sum()} corners, and has '
            f'{len(corners)}'
        )
    is_face = counts >= 3
    return cut_faces(corners[np.repeat(is_face, counts)], counts[is_face], positions).triangles


def _transform(node: Element) -> Floats:
    """Return the pose (4, 4) of a node in its parent, the product of its transforms."""
    T = np.eye(4)
    for child in node:
        if child.tag in ('matrix', 'translate', 'rotate', 'scale'):
            T = T @ _STEPS[child.tag](np.array((child.text or '').split(), dtype=np.float64))
        elif child.tag in ('lookat', 'skew'):
            raise ValueError(f'<{child.tag}> of <node id={node.get("id")!r}> is not read')
    return T


def _rotation(numbers: Floats) -> Floats:
    """Return the rotation (4, 4) about an axis (3,) by an angle [degrees]."""
    (x, y, z), angle = numbers[:3] / np.linalg.norm(numbers[:3]), math.radians(numbers[3])
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    T = np.eye(4)
    T[:3, :3] += math.sin(angle) * across + (1.0 - math.cos(angle)) * (across @ across)
    return T


def _translation(numbers: Floats) -> Floats:
    T = np.eye(4)
    T[:3, 3] = numbers
    return T


def _matrix(numbers: Floats) -> Floats:
    return numbers.reshape(4, 4)


def _scaling(numbers: Floats) -> Floats:
    x, y, z = numbers
    return np.diag([x, y, z, 1.0])


_STEPS = {'matrix': _matrix, 'translate': _translation, 'rotate': _rotation, 'scale': _scaling}
