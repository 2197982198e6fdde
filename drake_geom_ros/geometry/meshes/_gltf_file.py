"""glTF 2.0 files, as text (.gltf) and binary (.glb): the triangles of their scene, with Z up.

glTF has lengths in metres and its y axis up (its specification, 3.4). As in Drake and RViz its
(x, y, z) becomes (x, -z, y). Deformed or compressed meshes, such as with skins or Draco, are
errors.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any
from urllib.parse import unquote_to_bytes

import numpy as np

from drake_geom_ros.geometry.meshes._companions import companion_name
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh, Pieces
from drake_geom_ros.math.array_types import Floats, Indices

_JSON, _BINARY = 0x4E4F534A, 0x004E4942  # the types of chunks
_COMPONENTS = {5120: '<i1', 5121: '<u1', 5122: '<i2', 5123: '<u2', 5125: '<u4', 5126: '<f4'}
_WIDTHS = {'SCALAR': 1, 'VEC2': 2, 'VEC3': 3, 'VEC4': 4}
_STRIP, _FAN = 5, 6
_SURFACES = (4, _STRIP, _FAN)  # the other modes are points and lines
# Extensions that a file may require. They do not affect triangles, except the last one, which
# allows accessors of integers.
_HARMLESS = (
    *('KHR_materials_', 'KHR_texture_', 'EXT_texture_', 'MSFT_texture_', 'KHR_lights_'),
    *('EXT_lights_', 'KHR_mesh_quantization'),
)


_NO_FILES: Mapping[str, bytes] = MappingProxyType({})


def parse_gltf(data: bytes, companions: Mapping[str, bytes] = _NO_FILES) -> ParsedMesh:
    """Return the mesh of a file's scene, each mesh at the pose of its nodes.

    ``companions`` are the contents of the files that it names for its buffers. Points and lines
    give vertices without triangles. Raises ValueError, or another error for a
    document of another structure.
    """
    tree, binary = _document(data)
    version = str(tree['asset']['version'])
    if version.split('.')[0] != '2':
        raise ValueError(f'it is glTF {version}; 2.0 is read')
    odd = [name for name in tree.get('extensionsRequired', []) if not name.startswith(_HARMLESS)]
    if odd:
        raise ValueError(f'it requires {", ".join(odd)}, which is not read')
    return _GltfReader(tree, binary, companions).mesh()


def _document(data: bytes) -> tuple[Any, bytes | None]:
    """Return the tree of a file, and the buffer in a binary one."""
    if data[:4] != b'glTF':
        return json.loads(data), None
    version, length = struct.unpack_from('<II', data, 4)
    if version != 2:
        raise ValueError(f'it is binary glTF {version}; 2 is read')
    if length > len(data):
        raise ValueError(f'it tells of {length} bytes and has {len(data)}: it is truncated')
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from('<II', data, start)
        chunks.setdefault(kind, data[start + 8 : start + 8 + size])
        start += 8 + size
    return json.loads(chunks[_JSON]), chunks.get(_BINARY)


class _GltfReader:
    """Reads the scene of one document."""

    def __init__(self, tree: Any, binary: bytes | None, companions: Mapping[str, bytes]) -> None:
        self._tree = tree
        self._buffers = [
            _buffer(each, binary if k == 0 else None, companions)
            for k, each in enumerate(tree.get('buffers', []))
        ]
        self._pieces = Pieces()
        self._colours: list[Floats | None] = []

    def mesh(self) -> ParsedMesh:
        """Return the mesh of the scene."""
        seen: set[int] = set()
        stack = [(index, np.eye(4)) for index in reversed(self._roots())]
        while stack:
            index, T_FP = stack.pop()
            node = self._item('nodes', index)
            if index in seen:
                raise ValueError(f'node {index} is in the scene twice')
            seen.add(index)
            T_FN = T_FP @ _transform(node)
            if 'mesh' in node:
                self._add(index, node, T_FN)
            stack += [(child, T_FN) for child in reversed(node.get('children', []))]
        vertices, triangles = self._pieces.all()
        p_GVs = np.column_stack((vertices[:, 0], 0.0 - vertices[:, 2], vertices[:, 1]))
        colours = None
        if self._colours and all(each is not None for each in self._colours):
            colours = np.concatenate(self._colours).astype(np.float32)  # type: ignore[arg-type]
        return ParsedMesh(p_GVs, triangles, colours, ('turned from y up to z up',))

    def _item(self, kind: str, index: Any) -> Any:
        """Return an item of the document; raises an error for negative indices, too."""
        items = self._tree.get(kind, [])
        if not isinstance(index, int) or not 0 <= index < len(items):
            raise ValueError(f'there is no {kind}[{index}]')
        return items[index]

    def _roots(self) -> list[int]:
        """Return the root nodes of the default scene, or all roots without one."""
        if self._tree.get('scenes'):
            roots: list[int] = self._item('scenes', self._tree.get('scene', 0)).get('nodes', [])
            return roots
        nodes = self._tree.get('nodes', [])
        children = {child for node in nodes for child in node.get('children', [])}
        return [k for k in range(len(nodes)) if k not in children]

    def _add(self, index: int, node: Any, T_FN: Floats) -> None:
        mesh = self._item('meshes', node['mesh'])
        if 'skin' in node:
            raise ValueError(f'node {index} is bent by a skin; bake its pose into the mesh')
        if any(node.get('weights', mesh.get('weights', ()))):
            raise ValueError(f'node {index} is bent by morph targets; bake them into the mesh')
        if 'EXT_mesh_gpu_instancing' in node.get('extensions', {}):
            raise ValueError(f'node {index} has instances (EXT_mesh_gpu_instancing), not read')
        for primitive in mesh['primitives']:
            attributes = primitive['attributes']
            vertices = self._values(attributes['POSITION'], 3)
            triangles = self._triangles(primitive, len(vertices))
            self._pieces.add(T_FN, vertices, triangles)
            if len(triangles):
                colours = attributes.get('COLOR_0')
                self._colours.append(
                    None if colours is None else self._values(colours)[triangles, :3].mean(axis=1)
                )

    def _triangles(self, primitive: Any, count: int) -> Indices:
        """Return the triangles (m, 3) of a primitive with ``count`` vertices."""
        mode = primitive.get('mode', 4)
        if mode not in _SURFACES:
            return np.zeros((0, 3), dtype=np.int64)
        order = np.arange(count)
        if 'indices' in primitive:
            order = self._values(primitive['indices'], 1)[:, 0].astype(np.int64)
        if mode == _STRIP:
            return strip(order)
        if mode == _FAN:
            return fan(order)
        if len(order) % 3:
            raise ValueError(f'{len(order)} corners are no triangles')
        return order.reshape(-1, 3)

    def _values(self, index: Any, width: int = 0) -> Floats:
        """Return the numbers (n, width) of an accessor, normalised to [-1, 1] if it says so."""
        accessor = self._item('accessors', index)
        if 'sparse' in accessor or 'bufferView' not in accessor:
            raise ValueError(f'accessors[{index}] is sparse or packed, which is not read')
        view = self._item('bufferViews', accessor['bufferView'])
        buffer = self._buffers[view['buffer']]
        kind, count = np.dtype(_COMPONENTS[accessor['componentType']]), accessor['count']
        columns = _WIDTHS[accessor['type']]
        if width and columns != width:
            raise ValueError(f'accessors[{index}] has {columns} numbers each, not {width}')
        stride = view.get('byteStride', kind.itemsize * columns)
        start, first = view.get('byteOffset', 0), accessor.get('byteOffset', 0)
        needed = first + stride * (count - 1) + kind.itemsize * columns
        if count < 1 or min(start, first, stride) < 0 or needed > view['byteLength']:
            raise ValueError(f'accessors[{index}] tells of more numbers than its view holds')
        strides = (stride, kind.itemsize)
        numbers = np.ndarray((count, columns), kind, buffer, start + first, strides)
        if accessor.get('normalized'):
            return np.maximum(numbers.astype(np.float64) / np.iinfo(kind).max, -1.0)
        return numbers.astype(np.float64)


def strip(order: Indices) -> Indices:
    """Return the triangles (m, 3) of a strip through vertices."""
    triangles = np.column_stack((order[:-2], order[1:-1], order[2:]))
    triangles[1::2] = triangles[1::2, [1, 0, 2]]
    return triangles


def fan(order: Indices) -> Indices:
    """Return the triangles (m, 3) of a fan about its first vertex."""
    hub = np.broadcast_to(order[:1], len(order[2:]))
    return np.column_stack((hub, order[1:-1], order[2:]))


def _buffer(buffer: Any, binary: bytes | None, companions: Mapping[str, bytes]) -> bytes:
    """Return the bytes of a buffer, in the file or in one of its companions."""
    uri = buffer.get('uri')
    if uri is None:
        content = binary
    elif uri.startswith('data:'):
        header, _, text = uri.partition(',')
        raw = unquote_to_bytes(text)
        content = base64.b64decode(raw) if header.endswith(';base64') else raw
    else:
        name = companion_name(uri, 'it')
        if name not in companions:
            raise ValueError(f'its buffer {uri!r} is another file, which is not here')
        content = companions[name]
    if content is None or len(content) < buffer['byteLength']:
        raise ValueError(
            f'a buffer has {len(content or b"")} bytes of {buffer["byteLength"]}: it is truncated'
        )
    return content


def _transform(node: Any) -> Floats:
    """Return the pose (4, 4) of a node in its parent."""
    if 'matrix' in node:
        return np.array(node['matrix'], dtype=np.float64).reshape(4, 4).T
    T = np.eye(4)
    x, y, z, w = np.array(node.get('rotation', (0.0, 0.0, 0.0, 1.0)), dtype=np.float64)
    n = x * x + y * y + z * z + w * w
    if not n > 0.0:
        raise ValueError('a node has a rotation of length 0')
    T[:3, :3] += (2.0 / n) * np.array(
        [
            [-y * y - z * z, x * y - z * w, x * z + y * w],
            [x * y + z * w, -x * x - z * z, y * z - x * w],
            [x * z - y * w, y * z + x * w, -x * x - y * y],
        ]
    )
    T[:3, :3] *= np.array(node.get('scale', (1.0, 1.0, 1.0)), dtype=np.float64)
    T[:3, 3] = node.get('translation', (0.0, 0.0, 0.0))
    return T
