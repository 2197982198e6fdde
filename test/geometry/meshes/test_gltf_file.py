"""glTF files: turned Z up after all nodes, and whatever would be read in part refused."""

import base64

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, glb, gltf, gltf_tree
from oracles.shape_scenes import ShapeScene

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import Convex, InMemoryMesh, Mesh, MeshFileError, Sphere
from drake_geom_ros.geometry.meshes.source import facet_colours, mesh_source, remarks_on, surface

ONES = np.ones(3)
Z_UP = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])


def memory(content, extension='.gltf'):
    return InMemoryMesh(mesh_file=MemoryFile(content, extension, 'box'))


def extents(vertices):
    return [*vertices.min(axis=0).round(6).tolist(), *vertices.max(axis=0).round(6).tolist()]


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.fixture(params=['gltf', 'glb'])
def path(request, tmp_path):
    """The path of the box in either form."""
    path = tmp_path / f'box.{request.param}'
    path.write_bytes(glb() if request.param == 'glb' else gltf().encode())
    return str(path)


def test_y_up_becomes_z_up(path):
    vertices, triangles = surface(path, ONES)
    np.testing.assert_array_equal(vertices, BOX @ Z_UP.T)
    np.testing.assert_array_equal(triangles, SIDES)
    assert extents(vertices) == [0, -3, 0, 1, 0, 2]
    assert remarks_on(path) == ('turned from y up to z up',)


@pytest.mark.parametrize('kind', [Convex, Mesh])
def test_a_ball_where_the_box_is_touches_it(path, kind):
    """Read as it stands the file is 1.9 m away from this ball, which is 0.6 m deep in it."""
    pair = ShapeScene(kind(path), Sphere(0.1)).pair([0, 0, 0], [0.5, -2.0, 1.0])
    assert pair.distance == pytest.approx(-0.6, abs=1e-12)


def test_scales_are_along_the_axes_after_the_turn(path):
    """As in pydrake 1.51.1, whose hull of this box reaches from (0, -30, 0) to (1, 0, 200)."""
    assert extents(Convex(path, [1, 10, 100]).hull_surface()[0]) == [0, -30, 0, 1, 0, 200]
    assert extents(surface(path, np.array([1.0, 10.0, 100.0]))[0]) == [0, -30, 0, 1, 0, 200]


def test_the_turn_comes_after_all_nodes():
    s = np.sqrt(0.5)
    nodes = [
        {'translation': [10, 20, 30], 'children': [1]},
        {'rotation': [0, 0, s, s], 'scale': [1, 1, 2], 'mesh': 0},  # about z by 90 degrees
    ]
    vertices, triangles = surface(memory(gltf(nodes)), ONES)
    in_file = BOX * [1, 1, 2] @ np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]) + [10, 20, 30]
    np.testing.assert_allclose(vertices, in_file @ Z_UP.T, rtol=0, atol=1e-12)
    assert volume(vertices, triangles) == pytest.approx(12.0)


def test_matrices_instances_and_mirrors_count():
    matrix = np.diag([-1.0, 1, 1, 1])
    matrix[:3, 3] = 5, 0, 0
    nodes = [{'mesh': 0}, {'mesh': 0, 'matrix': matrix.T.ravel().tolist()}]
    vertices, triangles = surface(memory(gltf(nodes)), ONES)
    assert extents(vertices) == [0, -3, 0, 5, 0, 2]
    assert len(triangles) == 24
    assert volume(vertices, triangles) == pytest.approx(12.0)


def test_only_the_default_scene_is_read():
    nodes = [{'mesh': 0}, {'mesh': 0, 'translation': [9, 0, 0]}]
    scenes = [{'nodes': [0]}, {'nodes': [1]}]
    for scene, start in ((0, 0), (1, 9)):
        vertices, _ = surface(memory(gltf(nodes, scenes=scenes, scene=scene)), ONES)
        assert vertices[:, 0].min() == start
    tree = gltf(nodes, scenes=[])
    assert extents(surface(memory(tree), ONES)[0])[3] == 10


@pytest.mark.parametrize(('mode', 'order'), [(5, [0, 1, 2, 3]), (6, [0, 1, 3, 2])])
def test_strips_and_fans_are_triangles(mode, order):
    """A quad as a strip and as a fan, both its triangles turned alike."""
    tree = gltf_tree()
    tree['meshes'][0]['primitives'] = [{'attributes': {'POSITION': 0}, 'indices': 1, 'mode': mode}]
    data = BOX.astype('<f4').tobytes() + np.array(order, '<u2').tobytes()
    made = gltf(**{**tree, **with_buffer(tree, data, 4)})
    vertices, triangles = surface(memory(made), ONES)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    areas = np.cross(b - a, c - a) / 2
    assert len(triangles) == 2
    assert abs(areas.sum(axis=0)).max() == pytest.approx(6.0)  # they do not cancel


def with_buffer(tree, data, indices):
    uri = f'data:;base64,{base64.b64encode(data).decode()}'
    views = [{**tree['bufferViews'][0]}, {**tree['bufferViews'][1], 'byteLength': 2 * indices}]
    accessors = [tree['accessors'][0], {**tree['accessors'][1], 'count': indices}]
    buffers = [{'byteLength': len(data), 'uri': uri}]
    return {'bufferViews': views, 'accessors': accessors, 'buffers': buffers}


def test_a_fan_has_its_own_corners():
    """And not all vertices of its mesh: trimesh leaves fans out."""
    tree = gltf_tree()
    tree['meshes'][0]['primitives'] = [{'attributes': {'POSITION': 0}, 'indices': 1, 'mode': 6}]
    data = BOX.astype('<f4').tobytes() + np.array([7, 5, 4], '<u2').tobytes()
    _, triangles = surface(memory(gltf(**{**tree, **with_buffer(tree, data, 3)})), ONES)
    assert triangles.tolist() == [[7, 5, 4]]
    tree['meshes'][0]['primitives'] = [{'attributes': {'POSITION': 0}, 'mode': 6}]
    assert len(surface(memory(gltf(**tree)), ONES)[1]) == 6


def test_a_node_with_a_camera_keeps_its_mesh_and_its_children():
    nodes = [
        {'camera': 0, 'mesh': 0, 'translation': [1, 0, 0], 'children': [1]},
        {'mesh': 0, 'translation': [4, 0, 0], 'name': 'world'},
    ]
    cameras = [{'type': 'perspective', 'perspective': {'yfov': 1.0, 'znear': 0.1}}]
    vertices, triangles = surface(memory(gltf(nodes, cameras=cameras)), ONES)
    assert extents(vertices) == [1, -3, 0, 6, 0, 2]
    assert len(triangles) == 24


def test_points_and_lines_count_for_hulls_only():
    tree = gltf_tree()
    tree['meshes'][0]['primitives'] = [{'attributes': {'POSITION': 0}, 'mode': 1}]
    mesh = memory(gltf(**tree))
    assert len(surface(mesh, ONES)[1]) == 0
    assert extents(Convex(mesh).hull_surface()[0]) == [0, -3, 0, 1, 0, 2]


def test_quantized_positions_are_read():
    tree = gltf_tree([{'mesh': 0, 'scale': [3, 3, 3]}])
    packed = np.zeros((8, 4), '<u2')
    packed[:, :3] = np.round(BOX / 3 * 65535)
    data = packed.tobytes() + SIDES.astype('<u2').tobytes()
    changed = with_buffer(tree, data, 36)
    changed['bufferViews'] = [
        {'buffer': 0, 'byteLength': 64, 'byteStride': 8},
        {'buffer': 0, 'byteOffset': 64, 'byteLength': 72},
    ]
    changed['accessors'][0] = {
        'bufferView': 0,
        'componentType': 5123,
        'normalized': True,
        'count': 8,
        'type': 'VEC3',
    }
    changed['extensionsRequired'] = ['KHR_mesh_quantization']
    vertices, _ = surface(memory(gltf(**{**tree, **changed})), ONES)
    np.testing.assert_allclose(vertices, BOX @ Z_UP.T, rtol=0, atol=3 / 65535)


def test_colours_of_vertices_are_those_of_triangles():
    tree = gltf_tree()
    tree['meshes'][0]['primitives'][0]['attributes']['COLOR_0'] = 2
    tree['accessors'].append(
        {
            'bufferView': 2,
            'componentType': 5121,
            'normalized': True,
            'count': 8,
            'type': 'VEC4',
        }
    )
    data = BOX.astype('<f4').tobytes() + SIDES.astype('<u2').tobytes()
    changed = with_buffer(tree, data + bytes([0, 255, 51, 255]) * 8, 36)
    changed['accessors'].append(tree['accessors'][2])
    changed['bufferViews'].append({'buffer': 0, 'byteOffset': 168, 'byteLength': 32})
    colours = facet_colours(memory(gltf(**{**tree, **changed})))
    np.testing.assert_allclose(colours, np.tile([0, 1, 0.2], (12, 1)), rtol=0, atol=1e-7)
    assert facet_colours(memory(gltf())) is None


PRIMITIVE = {'attributes': {'POSITION': 0}, 'indices': 1}


@pytest.mark.parametrize(
    ('nodes', 'changes', 'reason'),
    [
        (None, {'extensionsRequired': ['KHR_draco_mesh_compression']}, 'KHR_draco'),
        (None, {'extensionsRequired': ['EXT_meshopt_compression']}, 'EXT_meshopt'),
        ([{'mesh': 0, 'skin': 0}], {}, 'skin'),
        ([{'mesh': 0, 'weights': [0.5]}], {}, 'morph targets'),
        ([{'mesh': 0, 'extensions': {'EXT_mesh_gpu_instancing': {}}}], {}, 'instances'),
        ([{'mesh': 3}], {}, r'no meshes\[3\]'),
        ([{'mesh': -1}], {}, r'no meshes\[-1\]'),
        ([{'children': [1]}, {'children': [1]}], {}, 'twice'),
        ([{}], {}, '0 vertices'),
        (None, {'asset': {'version': '1.0'}}, r'glTF 1\.0'),
        (None, {'meshes': [{'primitives': [{'attributes': {}}]}]}, 'POSITION'),
        (None, {'accessors': [{'componentType': 5126, 'count': 8, 'type': 'VEC3'}]}, 'sparse'),
        (
            None,
            {'buffers': [{'byteLength': 168, 'uri': 'box.bin'}]},
            "'box.bin' is another file, which is",
        ),
        (None, {'buffers': [{'byteLength': 168, 'uri': '../box.bin'}]}, 'in its own folder'),
        (None, {'buffers': [{'byteLength': 168, 'uri': '/tmp/box.bin'}]}, 'in its own folder'),
        (None, {'buffers': [{'byteLength': 168, 'uri': 'http://a/b.bin'}]}, 'in its own folder'),
        (None, {'buffers': [{'byteLength': 168, 'uri': 'data:;base64,AAAA'}]}, '3 bytes of 168'),
    ],
)
def test_what_would_be_read_in_part_or_not_at_all_is_refused(nodes, changes, reason):
    with pytest.raises(MeshFileError, match=reason):
        surface(memory(gltf(nodes, **changes)), ONES)


def test_a_truncated_binary_file_is_refused():
    with pytest.raises(MeshFileError, match=r'tells of \d+ bytes and has \d+: it is truncated'):
        surface(memory(glb()[:-20], '.glb'), ONES)


def test_an_index_of_no_vertex_is_refused():
    tree = gltf_tree()
    data = BOX.astype('<f4').tobytes() + np.array([0, 1, 8], '<u2').tobytes()
    with pytest.raises(MeshFileError, match='vertex 8; there are 8'):
        surface(memory(gltf(**{**tree, **with_buffer(tree, data, 3)})), ONES)


def beside(folder, points=BOX):
    """Write the box as a document whose buffer is a file in a folder below; return its path."""
    data = points.astype('<f4').tobytes() + SIDES.astype('<u2').tobytes()
    (folder / 'a b').mkdir(exist_ok=True)
    (folder / 'a b' / 'box.bin').write_bytes(data)
    path = folder / 'box.gltf'
    path.write_text(gltf(buffers=[{'byteLength': len(data), 'uri': 'a%20b/box.bin'}]))
    return str(path)


def test_a_buffer_in_a_file_beside_it_is_read(tmp_path):
    vertices, triangles = surface(beside(tmp_path), ONES)
    np.testing.assert_array_equal(vertices, BOX @ Z_UP.T)
    np.testing.assert_array_equal(triangles, SIDES)


def test_another_buffer_makes_another_mesh(tmp_path):
    """The document stays the same."""
    path = beside(tmp_path)
    first = mesh_source(path)
    assert surface(path, ONES)[0].max() == 2.0
    beside(tmp_path, 2.0 * BOX)
    assert mesh_source(path) != first
    assert surface(path, ONES)[0].max() == 4.0


def test_a_missing_buffer_is_named(tmp_path):
    path = beside(tmp_path)
    (tmp_path / 'a b' / 'box.bin').unlink()
    with pytest.raises(MeshFileError, match=r'a b/box\.bin.*cannot be read: No such file'):
        surface(path, ONES)


def test_a_buffer_of_a_mesh_in_memory_is_among_its_files():
    points, corners = BOX.astype('<f4').tobytes(), SIDES.astype('<u2').tobytes()
    text = gltf(buffers=[{'byteLength': len(points + corners), 'uri': 'box.bin'}])
    files = {'box.bin': MemoryFile(points + corners, '.bin', 'box')}
    mesh = InMemoryMesh(mesh_file=MemoryFile(text, '.gltf', 'box'), supporting_files=files)
    np.testing.assert_array_equal(surface(mesh, ONES)[0], BOX @ Z_UP.T)
