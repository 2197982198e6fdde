"""PLY files: faces of any number of corners, rows of any shape, whole or refused."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import InMemoryMesh, MeshFileError
from drake_geom_ros.geometry.meshes.source import facet_colours, surface

QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
MIXED = [*QUADS[:3], *SIDES[6:].tolist()]
ORDERS = {'binary_little_endian': '<', 'binary_big_endian': '>'}


def memory(content):
    return InMemoryMesh(mesh_file=MemoryFile(content, '.ply', 'box'))


def read(content):
    return surface(memory(content), np.ones(3))


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


def ply(order='ascii', faces=SIDES, told=None, list_name='vertex_indices', extra=''):
    """Return the box in PLY, each vertex with a flag, each face with a quality before its list."""
    told = len(faces) if told is None else told
    header = (
        f'ply\nformat {order} 1.0\ncomment made by hand\nobj_info units mm\n'
        'element vertex 8\nproperty float x\nproperty float y\nproperty float z\n'
        f'property uchar flag\nelement face {told}\nproperty short quality\n'
        f'property list uchar int {list_name}\n{extra}end_header\n'
    )
    if order == 'ascii':
        rows = [f'{x:g} {y:g} {z:g} 7' for x, y, z in BOX]
        rows += [f'-1 {len(face)} {" ".join(map(str, face))}' for face in faces]
        return (header + '\n'.join(rows) + '\n').encode()
    end = ORDERS[order]
    body = b''.join(p.astype(f'{end}f4').tobytes() + b'\x07' for p in BOX)
    for face in faces:
        body += np.array(-1, f'{end}i2').tobytes() + bytes([len(face)])
        body += np.array(face, f'{end}i4').tobytes()
    return header.encode() + body


@pytest.mark.parametrize('order', ['ascii', *ORDERS])
@pytest.mark.parametrize('faces', [SIDES, QUADS, MIXED, MIXED[::-1]], ids=str)
def test_all_faces_are_read(order, faces):
    vertices, triangles = read(ply(order, faces))
    np.testing.assert_array_equal(vertices, BOX)
    assert volume(vertices, triangles) == pytest.approx(6.0)
    assert len(triangles) == 12


@pytest.mark.parametrize('order', ['ascii', *ORDERS])
def test_a_pentagon_is_no_quad(order):
    """The side at x = 0 with a fifth corner, which lies on an edge."""
    points = np.vstack([BOX, [0, 1, 0]])
    text = ply(order, [[0, 1, 3, 2, 8], *QUADS[1:]])
    if order == 'ascii':
        text = text.replace(b'vertex 8', b'vertex 9').replace(b'1 2 3 7\n', b'1 2 3 7\n0 1 0 7\n')
    else:
        row = BOX[7].astype(f'{ORDERS[order]}f4').tobytes() + b'\x07'
        more = points[8].astype(f'{ORDERS[order]}f4').tobytes() + b'\x07'
        text = text.replace(b'vertex 8', b'vertex 9').replace(row, row + more, 1)
    vertices, triangles = read(text)
    np.testing.assert_array_equal(vertices, points)
    assert volume(vertices, triangles) == pytest.approx(6.0)
    assert len(triangles) == 13


def test_vertices_alone_are_points():
    text = ply().split(b'element face')[0] + b'end_header\n'
    rows = '\n'.join(f'{x:g} {y:g} {z:g} 7' for x, y, z in BOX)
    vertices, triangles = read(text + rows.encode())
    np.testing.assert_array_equal(vertices, BOX)
    assert len(triangles) == 0


@pytest.mark.parametrize('kind', ['uchar', 'float'])
def test_colours_of_faces_go_before_those_of_vertices(kind):
    full = '255' if kind == 'uchar' else '1'
    colour = ''.join(f'property {kind} {name}\n' for name in ('red', 'green', 'blue'))
    text = ply(faces=QUADS).decode().replace('property uchar flag\n', colour)
    lines = [
        line[:-1] + f'{full} 0 0' if line.endswith(' 7') else line for line in text.split('\n')
    ]
    of_vertices = '\n'.join(lines)
    np.testing.assert_array_equal(facet_colours(memory(of_vertices)), np.tile([1, 0, 0], (12, 1)))
    of_faces = of_vertices.replace('vertex_indices\n', f'vertex_indices\n{colour}')
    lines = [
        f'{line} 0 {full} 0' if line.startswith('-1') else line for line in of_faces.split('\n')
    ]
    found = facet_colours(memory('\n'.join(lines)))
    np.testing.assert_array_equal(found, np.tile([0, 1, 0], (12, 1)))
    assert facet_colours(memory(ply())) is None


@pytest.mark.parametrize('order', ['ascii', *ORDERS])
def test_a_truncated_file_is_refused(order):
    with pytest.raises(MeshFileError, match=r"13 rows of 'face': it is truncated"):
        read(ply(order, told=13))
    with pytest.raises(MeshFileError, match=r'\d+ (bytes|numbers) are left over'):
        read(ply(order, told=11))


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (ply(faces=[[0, 1, 8]]), 'vertex 8; there are 8'),
        (ply(faces=[[0, 1]]), 'face 0 has 2 corners'),
        (ply(list_name='corners'), 'no list'),
        (ply(extra='element tristrips 0\nproperty list int int vertex_indices\n'), 'tristrips'),
        (ply(extra='nonsense\n'), 'nonsense'),
        (ply().replace(b'ascii', b'utf-8'), 'utf-8'),
        (ply().replace(b'property float x', b'property half x'), 'half'),
        (b'solid', 'does not begin as a PLY file'),
    ],
)
def test_what_is_not_understood_is_refused(content, reason):
    with pytest.raises(MeshFileError, match=reason):
        read(content)


@pytest.mark.parametrize(
    ('line', 'twice', 'told'),
    [
        (b'property float x\n', b'property float x\n', "vertex property 'x' twice"),
        (b'property short quality\n', b'property int quality\n', "face property 'quality' twice"),
        (b'element face 12\n', b'element vertex 8\n', "element 'vertex' twice"),
    ],
)
def test_what_a_header_has_twice_is_refused(line, twice, told):
    content = ply()
    assert line in content
    with pytest.raises(MeshFileError, match=told):
        read(content.replace(line, twice + line, 1))


@pytest.mark.parametrize(
    ('line', 'other', 'told'),
    [
        (b'property float z\n', b'property float w\n', 'has no z of an element'),
        (b'element vertex 8\n', b'element point 8\n', 'has no x, y, z of an element'),
    ],
)
def test_vertices_without_a_coordinate_are_refused(line, other, told):
    with pytest.raises(MeshFileError, match=told):
        read(ply().replace(line, other, 1))


def test_numbers_of_text_are_not_rounded_to_their_type():
    text = ply().replace(b'0 0 0 7\n', b'0.1 0 1e-9 7\n', 1)
    assert read(text)[0][0].tolist() == [0.1, 0.0, 1e-9]


@pytest.mark.parametrize(
    ('row', 'damaged', 'reason'),
    [
        (b'-1 3 0 1 3\n', b'-1 4 0 1 3\n', "a row of 'face' has 5 numbers, not 6"),
        (b'-1 3 0 1 3\n', b'-1 3 0 1 3 2\n', "a row of 'face' has 6 numbers, not 5"),
        (b'-1 3 0 1 3\n', b'-1 4 0 1 3 x\n', 'of its .* can be read|could not be read'),
        (b'1 2 3 7\n', b'1 x 3 7\n', 'can be read|could not be read|holds no mesh'),
    ],
)
def test_a_row_of_text_that_trimesh_would_cut_is_refused(row, damaged, reason):
    content = ply()
    assert row in content
    with pytest.raises(MeshFileError, match=reason):
        read(content.replace(row, damaged, 1))


@pytest.mark.parametrize('order', ['ascii', *ORDERS])
def test_other_elements_and_texture_coordinates_are_passed_over(order):
    """Edges would be a path for trimesh, and coordinates of textures another order of vertices."""
    extra = 'element edge 2\nproperty int vertex1\nproperty int vertex2\n'
    content = ply(order, MIXED, extra=extra).replace(b'uchar flag', b'uchar s')
    if order == 'ascii':
        content += b'0 1\n1 2\n'
    else:
        content += np.array([0, 1, 1, 2], f'{ORDERS[order]}i4').tobytes()
    vertices, triangles = read(content)
    np.testing.assert_array_equal(vertices, BOX)
    assert volume(vertices, triangles) == pytest.approx(6.0)
