"""Mesh files of a box and of what a test wants, written as text."""

import base64
import io
import json
import struct
import zipfile

import numpy as np

# The box from the origin to (1, 2, 3), its triangles counter-clockwise from outside.
BOX = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)
SIDES = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)

CENTRE = BOX.mean(axis=0)


def vtk(points=None, cells=None, kinds=None, version='3.0'):
    """Return a legacy .vtk file of tetrahedra, those of the box about its centre."""
    if points is None:
        points = np.vstack((BOX, CENTRE))
    if cells is None:
        cells = [(*side, len(BOX)) for side in SIDES[:, ::-1].tolist()]
    lines = [f'# vtk DataFile Version {version}', 'tetrahedra', 'ASCII']
    lines += ['DATASET UNSTRUCTURED_GRID', f'POINTS {len(points)} double']
    lines += [' '.join(map(repr, row)) for row in np.asarray(points, dtype=float).tolist()]
    lines += [f'CELLS {len(cells)} {sum(len(cell) + 1 for cell in cells)}']
    lines += [' '.join(map(str, (len(cell), *cell))) for cell in cells]
    lines += [f'CELL_TYPES {len(cells)}', *map(str, kinds or [10] * len(cells))]
    return '\n'.join(lines) + '\n'


def gltf_tree(nodes=None, **changes):
    """Return glTF 2.0 of the box: mesh 0, with these nodes (all of them in the scene)."""
    points, corners = BOX.astype('<f4').tobytes(), SIDES.astype('<u2').tobytes()
    data = base64.b64encode(points + corners).decode()
    nodes = [{'mesh': 0}] if nodes is None else nodes
    children = {child for node in nodes for child in node.get('children', [])}
    tree = {
        'asset': {'version': '2.0'},
        'scene': 0,
        'scenes': [{'nodes': [k for k in range(len(nodes)) if k not in children]}],
        'nodes': nodes,
        'meshes': [{'primitives': [{'attributes': {'POSITION': 0}, 'indices': 1}]}],
        'accessors': [
            {'bufferView': 0, 'componentType': 5126, 'count': 8, 'type': 'VEC3'},
            {'bufferView': 1, 'componentType': 5123, 'count': 36, 'type': 'SCALAR'},
        ],
        'bufferViews': [
            {'buffer': 0, 'byteOffset': 0, 'byteLength': len(points)},
            {'buffer': 0, 'byteOffset': len(points), 'byteLength': len(corners)},
        ],
        'buffers': [
            {
                'byteLength': len(points + corners),
                'uri': f'data:application/octet-stream;base64,{data}',
            }
        ],
    }
    tree['accessors'][0].update(min=[0, 0, 0], max=[1, 2, 3])
    return {**tree, **changes}


def gltf(nodes=None, **changes):
    """Return the text of ``gltf_tree``."""
    return json.dumps(gltf_tree(nodes, **changes))


def glb(nodes=None, **changes):
    """Return the bytes of ``gltf_tree`` as binary glTF."""
    tree = gltf_tree(nodes, **changes)
    data = base64.b64decode(tree['buffers'][0].pop('uri').split(',')[1])
    text = json.dumps(tree).encode()
    text += b' ' * (-len(text) % 4)
    chunks = struct.pack('<II', len(text), 0x4E4F534A) + text
    chunks += struct.pack('<II', len(data), 0x004E4942) + data
    return b'glTF' + struct.pack('<II', 2, 12 + len(chunks)) + chunks


def words(numbers):
    """Return numbers as text."""
    return ' '.join(f'{x:g}' for x in np.ravel(numbers))


def primitive(tag='triangles', loops=(SIDES,), inner='', count=12):
    """Return a primitive of Collada, a <p> for each of the loops."""
    text = ''.join(f'<p>{words(loop)}</p>' for loop in loops)
    return (
        f'<{tag} count="{count}"><input semantic="VERTEX" source="#v" offset="0"/>'
        f'{inner}{text}</{tag}>'
    )


def dae(unit='', axis='Z_UP', nodes='', shapes=None, library=''):
    """Return Collada of the box, placed by these nodes."""
    nodes = nodes or '<node><instance_geometry url="#g"/></node>'
    shapes = primitive() if shapes is None else shapes
    return f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>{axis}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="24">{words(BOX)}</float_array>
<technique_common><accessor source="#pa" count="8" stride="3">
<param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
{shapes}
</mesh></geometry></library_geometries>
{library}
<library_visual_scenes><visual_scene id="s">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


def off(points=BOX, faces=SIDES, header='OFF', counts=None):
    """Return an OFF file of the box, or of other faces."""
    counts = f'{len(points)} {len(faces)} 0' if counts is None else counts
    lines = [header, counts, *(' '.join(map(repr, map(float, row))) for row in points)]
    return (
        '\n'.join([*lines, *(f'{len(face)} {" ".join(map(str, face))}' for face in faces)]) + '\n'
    )


def threemf(unit='meter', item='', vertices=None, more='', build='1', model='3D/3dmodel.model'):
    """Return a 3MF file of the box; ``more`` follows its object."""
    rows = BOX.tolist() if vertices is None else vertices
    points = ''.join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in rows)
    sides = ''.join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in SIDES.tolist())
    text = (
        '<?xml version="1.0"?><model xmlns="http://schemas.microsoft.com/3dmanufacturing/core/'
        f'2015/02" unit="{unit}"><resources><object id="1" type="model"><mesh><vertices>{points}'
        f'</vertices><triangles>{sides}</triangles></mesh></object>{more}</resources><build>'
        f'<item objectid="{build}"{item}/></build></model>'
    )
    content = io.BytesIO()
    with zipfile.ZipFile(content, 'w') as archive:
        archive.writestr(model, text)
    return content.getvalue()
