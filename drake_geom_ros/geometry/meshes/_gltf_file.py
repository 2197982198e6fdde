"""glTF 2.0 files, as text (.gltf) and binary (.glb): the triangles of their scene, with Z up.

glTF has lengths in metres and its y axis up (its specification, 3.4). As in Drake and RViz its
(x, y, z) becomes (x, -z, y). Deformed or compressed meshes, such as with skins or Draco, are
errors. trimesh parses the numbers and the poses of nodes. It would leave out fans, nodes that
hold a camera and what is compressed, and take integers and negative indices as they stand; so it
gets a document of what counts alone, once that is checked.
"""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple
from urllib.parse import unquote_to_bytes

import numpy as np

from drake_geom_ros.geometry.meshes import _by_trimesh
from drake_geom_ros.geometry.meshes._companions import companion_name
from drake_geom_ros.geometry.meshes._parsed_mesh import ParsedMesh, Pieces
from drake_geom_ros.geometry.meshes._polygons import fan
from drake_geom_ros.math.array_types import Floats, Indices

_JSON, _BINARY = 0x4E4F534A, 0x004E4942  # the types of chunks
_POINTS, _TRIANGLES, _STRIP, _FAN = 0, 4, 5, 6  # modes; the others are lines
# Extensions that a file may require. They do not affect triangles, except the last one, which
# allows accessors of integers.
_HARMLESS = (
    *('KHR_materials_', 'KHR_texture_', 'EXT_texture_', 'MSFT_texture_', 'KHR_lights_'),
    *('EXT_lights_', 'KHR_mesh_quantization'),
)
_OF_NODES = ('children', 'matrix', 'translation', 'rotation', 'scale')
_NO_FILES: Mapping[str, bytes] = MappingProxyType({})


class _Node(NamedTuple):
    """A node of the scene that has a mesh, by its name for trimesh."""

    name: str
    mesh: int


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
    buffers = [
        _buffer(each, binary if k == 0 else None, companions)
        for k, each in enumerate(tree.get('buffers', []))
    ]
    nodes = list(_nodes(tree))
    loaded = _parsed(tree, sorted({node.mesh for node in nodes}), buffers)
    return _mesh(tree, nodes, loaded)


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


def _item(tree: Any, kind: str, index: Any) -> Any:
    """Return an item of the document; raises an error for negative indices, too."""
    items = tree.get(kind, [])
    if not isinstance(index, int) or not 0 <= index < len(items):
        raise ValueError(f'there is no {kind}[{index}]')
    return items[index]


def _roots(tree: Any) -> list[int]:
    """Return the root nodes of the default scene, or all roots without one."""
    if tree.get('scenes'):
        roots: list[int] = _item(tree, 'scenes', tree.get('scene', 0)).get('nodes', [])
        return roots
    nodes = tree.get('nodes', [])
    children = {child for node in nodes for child in node.get('children', [])}
    return [k for k in range(len(nodes)) if k not in children]


def _nodes(tree: Any) -> Iterator[_Node]:
    """Yield the nodes of the scene that have meshes, in its order.

    Raises ValueError for a node that is there twice, and for one that bends or repeats its mesh.
    """
    seen: set[int] = set()
    stack = [*reversed(_roots(tree))]
    while stack:
        index = stack.pop()
        node = _item(tree, 'nodes', index)
        if index in seen:
            raise ValueError(f'node {index} is in the scene twice')
        seen.add(index)
        if not any(node.get('rotation', (1.0,))):
            raise ValueError('a node has a rotation of length 0')
        if 'mesh' in node:
            weights = _item(tree, 'meshes', node['mesh']).get('weights', ())
            if 'skin' in node:
                raise ValueError(f'node {index} is bent by a skin; bake its pose into the mesh')
            if any(node.get('weights', weights)):
                raise ValueError(f'node {index} is bent by morph targets; bake them into the mesh')
            if 'EXT_mesh_gpu_instancing' in node.get('extensions', {}):
                raise ValueError(f'node {index} has instances (EXT_mesh_gpu_instancing), not read')
            yield _Node(str(index), node['mesh'])
        stack += reversed(node.get('children', []))


def _parsed(tree: Any, meshes: list[int], buffers: list[bytes]) -> Any:
    """Return what trimesh makes of meshes, and of all nodes.

    A primitive of a mesh is a mesh of its own there, by the name MESH/NUMBER. Points are all
    primitives but triangles and strips; the corners of a fan are the points MESH/NUMBER/order.
    """
    nodes: list[dict[str, Any]] = [
        {'name': str(k), **{key: node[key] for key in _OF_NODES if key in node}}
        for k, node in enumerate(tree.get('nodes', []))
    ]
    parts: list[dict[str, Any]] = []
    for mesh in meshes:
        for k, primitive in enumerate(tree['meshes'][mesh]['primitives']):
            attributes, mode = primitive['attributes'], primitive.get('mode', _TRIANGLES)
            used = {'POSITION': _accessor(tree, attributes['POSITION'], 'VEC3')}
            if 'COLOR_0' in attributes:
                used['COLOR_0'] = _accessor(tree, attributes['COLOR_0'])
            part: dict[str, Any] = {'attributes': used, 'mode': _POINTS}
            parts.append({'name': f'{mesh}/{k}', 'primitives': [part]})
            if mode in (_TRIANGLES, _STRIP, _FAN) and 'indices' in primitive:
                part['indices'] = _accessor(tree, primitive['indices'], 'SCALAR')
            if mode in (_TRIANGLES, _STRIP):
                part['mode'] = mode
            elif mode == _FAN and 'indices' in part:
                order = {'attributes': {'POSITION': part['indices']}, 'mode': _POINTS}
                parts.append({'name': f'{mesh}/{k}/order', 'primitives': [order]})
    document = {
        'asset': {'version': '2.0'},
        'scenes': [{'nodes': _roots(tree)}],
        'nodes': nodes,
        'meshes': parts,
        'accessors': tree.get('accessors', []),
        'bufferViews': tree.get('bufferViews', []),
        'buffers': [{'uri': str(k)} for k in range(len(buffers))],
    }
    files = {str(k): content for k, content in enumerate(buffers)}
    return _by_trimesh.parsed(json.dumps(document).encode(), 'gltf', files, skip_materials=True)


def _accessor(tree: Any, index: Any, kind: str = '') -> int:
    """Return the index of an accessor of numbers; ValueError for one that is not read."""
    accessor = _item(tree, 'accessors', index)
    if 'sparse' in accessor or 'bufferView' not in accessor:
        raise ValueError(f'accessors[{index}] is sparse or packed, which is not read')
    view = _item(tree, 'bufferViews', accessor['bufferView'])
    _item(tree, 'buffers', view['buffer'])
    if kind and accessor['type'] != kind:
        raise ValueError(f'accessors[{index}] is of the type {accessor["type"]}, not {kind}')
    if min(view.get('byteOffset', 0), accessor.get('byteOffset', 0), accessor['count'] - 1) < 0:
        raise ValueError(f'accessors[{index}] is empty, or begins before its view')
    return int(index)


def _mesh(tree: Any, nodes: list[_Node], loaded: Any) -> ParsedMesh:
    """Return the mesh of the nodes from what trimesh has made of the document."""
    T_FNs = {loaded['base_frame']: np.eye(4)}  # poses of nodes in the file, by their names
    for edge in loaded['graph']:
        T_FNs[edge['frame_to']] = T_FNs[edge['frame_from']] @ edge['matrix']
    pieces = Pieces()
    colours: list[Floats | None] = []
    for node in nodes:
        for k, primitive in enumerate(tree['meshes'][node.mesh]['primitives']):
            name, attributes = f'{node.mesh}/{k}', primitive['attributes']
            part, order = (loaded['geometry'].get(each) for each in (name, f'{name}/order'))
            triangles = _triangles(primitive, part, order)
            positions = _reals(tree, attributes['POSITION'], part)
            pieces.add(T_FNs[node.name], positions, triangles, _name(tree, node))
            if len(triangles):
                of_vertices = _reals(tree, attributes.get('COLOR_0'), part, 'vertex_colors')
                colours.append(
                    of_vertices[triangles, :3].mean(axis=1) if len(of_vertices) else None
                )
    vertices, triangles = pieces.all()
    p_GVs = np.column_stack((vertices[:, 0], 0.0 - vertices[:, 2], vertices[:, 1]))
    part_colours = [each for each in colours if each is not None]
    is_coloured = bool(part_colours) and len(part_colours) == len(colours)
    of_triangles = np.concatenate(part_colours).astype(np.float32) if is_coloured else None
    remarks = ('turned from y up to z up',)
    return ParsedMesh(p_GVs, triangles, of_triangles, remarks, parts=pieces.parts())


def _name(tree: Any, node: _Node) -> str:
    return str(tree['nodes'][int(node.name)].get('name', ''))


def _triangles(primitive: Any, part: Any, order: Any) -> Indices:
    """Return the triangles (m, 3) of a primitive; ``order`` has the corners of a fan."""
    if primitive.get('mode', _TRIANGLES) == _FAN:
        all_vertices = np.arange(len(part['vertices']))
        return fan(all_vertices if order is None else order['vertices'].ravel().astype(np.int64))
    faces: Indices = np.asarray(part.get('faces', np.zeros((0, 3))), dtype=np.int64)
    return faces


def _reals(tree: Any, index: int | None, part: Any, name: str = 'vertices') -> Floats:
    """Return the numbers of an accessor, normalised to [-1, 1] if it says so; none for None."""
    if index is None:
        return np.zeros((0, 3))
    numbers = part[name]
    if tree['accessors'][index].get('normalized'):
        numbers = np.maximum(numbers.astype(np.float64) / np.iinfo(numbers.dtype).max, -1.0)
    reals: Floats = numbers.astype(np.float64)
    return reals
