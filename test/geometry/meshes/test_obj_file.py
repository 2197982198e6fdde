"""Reading .obj files: what the format allows, errors with file and line, and triangulation."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros.geometry import MeshFileError
from drake_geom_ros.geometry.meshes import _obj_file
from drake_geom_ros.geometry.meshes._obj_file import read_obj
from drake_geom_ros.geometry.meshes._polygons import triangulate

SQUARE = 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n'


def read(tmp_path, text):
    path = tmp_path / 'part.obj'
    path.write_text(text)
    return read_obj(path)


def test_a_triangle(tmp_path):
    vertices, triangles = read(tmp_path, 'v 0 0 0\nv 1 0 0\nv 0 1e0 0\nf 1 2 3\n')
    assert vertices.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert triangles.tolist() == [[0, 1, 2]]
    assert triangles.dtype == np.int64


@pytest.mark.parametrize(
    'faces',
    [
        'f 1 2 3 4',
        'f 1/1 2/2 3/1 4/2',
        'f 1//3 2//3 3//3 4//3',
        'f 1/1/3 2/1/3 3/1/3 4/1/3',
        'f -4 -3 -2 -1',
        'f 1 2 \\\n  3 4',
        'f 1 2\\\n 3 4   # a comment',
        'f 1 2 3 4 \\',
        '  f  1\t2 3 4\r',
        'o one\ng left\nusemtl red\ns off\nvn 0 0 1\nvt 0 0\nf 1 2 3\no two\nf 1 3 4',
    ],
)
def test_faces_in_all_spellings(tmp_path, faces):
    vertices, triangles = read(tmp_path, f'# a square\n\n{SQUARE}{faces}\n')
    assert len(vertices) == 4
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_a_byte_order_mark_hides_no_vertex(tmp_path):
    text = f'\ufeff{SQUARE}f 1 2 3\n'
    assert read(tmp_path, text)[0].tolist() == read(tmp_path, text[1:])[0].tolist()


@given(st.text(st.sampled_from('v1 \\#\n\r\v\f\x1c\x85\u2028')), st.integers(0, 5))
def test_lines_are_those_of_the_whole_text(text, block):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(_obj_file, '_BLOCK', block)
        assert list(_obj_file._lines(text)) == text.splitlines()


def test_objects_are_merged(tmp_path):
    text = (
        f'o a\n{SQUARE}f 1 2 3\no b\nv 0 0 5\nv 1 0 5\nv 0 1 5 0.5 0.5 0.5\nf -3 -2 -1\nf 5 6 7\n'
    )
    vertices, triangles = read(tmp_path, text)
    assert len(vertices) == 7
    assert triangles.tolist() == [[0, 1, 2], [4, 5, 6], [4, 5, 6]]


def test_relative_indices_count_from_their_line(tmp_path):
    """Not from the end of the file, as trimesh alone takes them."""
    text = f'{SQUARE}f -4 -3 -2\nf -1 1 3\n{SQUARE}f -4 -3 -2 -1\n'
    triangles = read(tmp_path, text)[1].tolist()
    assert triangles == [[0, 1, 2], [3, 0, 2], [4, 5, 6], [4, 6, 7]]


@given(
    rows=st.lists(st.tuples(*3 * [st.floats(-1e3, 1e3)]), min_size=6, max_size=9),
    sizes=st.lists(st.integers(3, 6), min_size=1, max_size=8),
    spelling=st.sampled_from(['{}', '{}/1', '{}//2', '{}/1/2', '0{}']),
    data=st.data(),
)
def test_what_is_written_is_read_to_the_last_bit(tmp_path_factory, rows, sizes, spelling, data):
    """Vertices and faces in their order, however many corners the faces have."""
    corners = st.permutations(range(len(rows)))
    faces = [data.draw(corners)[:size] for size in sizes]
    lines = [f'v {x!r} {y!r} {z!r}' for x, y, z in rows]
    lines += ['f ' + ' '.join(spelling.format(k + 1) for k in face) for face in faces]
    vertices, triangles = read(tmp_path_factory.mktemp('obj'), '\n'.join(lines))
    assert vertices.tolist() == [list(row) for row in rows]
    expected = [t for face in faces for t in triangulate(list(face), [rows[k] for k in face])]
    assert triangles.tolist() == [list(each) for each in expected]


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('', "part.obj' has no faces"),
        (SQUARE, 'has no faces'),
        (SQUARE + 'f 1 2 5\nv 0 0 1', r'part.obj:5: there is no vertex 5, the file has 5|never'),
        (SQUARE + 'f 1 2 6\n', r'part.obj:5: there is no vertex 6, the file has 4'),
        (SQUARE + 'f 0 1 2\n', r'part.obj:5: there is no vertex 0; 4 were given by then'),
        (SQUARE + 'f -5 1 2\n', r'part.obj:5: there is no vertex -5'),
        (SQUARE + 'f 1 2\n', r'part.obj:5: a face needs at least three vertices'),
        (SQUARE + 'f 1 2 x\n', r"part.obj:5: 'x' is not the index of a vertex"),
        (SQUARE + 'f 1 2 1.5\n', "'1.5' is not the index"),
        ('v 0 0\n', r'part.obj:1: a vertex needs three finite numbers'),
        ('v 0 0 a\n', r'part.obj:1: a vertex'),
        ('\nv 0 0 nan\n', r'part.obj:2: a vertex'),
        ('v 0 0 1e999\n', r'part.obj:1: a vertex'),
        (SQUARE + 'f 1 2 3\nsurf 0 1 0 1 1 2 3 4\n', r"part.obj:6: 'surf' is not read"),
        (SQUARE + 'call other.obj\nf 1 2 3\n', r"part.obj:5: 'call' is not read"),
    ],
)
def test_errors_name_file_and_line(tmp_path, text, words):
    if words.endswith('never'):
        assert len(read(tmp_path, text)[1]) == 1  # a vertex may come after its face
        return
    with pytest.raises(MeshFileError, match=words):
        read(tmp_path, text)


def test_files_that_cannot_be_read(tmp_path):
    with pytest.raises(MeshFileError, match=r"no.obj' cannot be read: No such file"):
        read_obj(tmp_path / 'no.obj')
    with pytest.raises(MeshFileError, match='cannot be read'):
        read_obj(tmp_path)
    (tmp_path / 'binary.obj').write_bytes(bytes(range(256)))
    with pytest.raises(MeshFileError, match='has no faces'):
        read_obj(tmp_path / 'binary.obj')


# Triangulation.


def areas_along(normal, corners, triangles):
    """Return the signed area of each triangle, seen against the normal."""
    a, b, c = np.array(corners)[np.array(triangles).T]
    return 0.5 * np.cross(b - a, c - a) @ normal


def star(radii, tilt):
    """Return a polygon that is star-shaped about its middle, counter-clockwise, tilted."""
    n = len(radii)
    angles = 2 * math.pi * np.arange(n) / n
    flat = np.column_stack((radii * np.cos(angles), radii * np.sin(angles), np.zeros(n)))
    R = np.array(
        [[1, 0, 0], [0, math.cos(tilt), -math.sin(tilt)], [0, math.sin(tilt), math.cos(tilt)]]
    )
    return flat @ R.T + [5, -3, 2], R[:, 2]


@given(
    radii=st.lists(st.floats(0.1, 1.0), min_size=4, max_size=12).map(np.array),
    tilt=st.floats(-math.pi, math.pi),
)
def test_a_polygon_that_is_not_convex_is_covered_once(radii, tilt):
    corners, normal = star(radii, tilt)
    triangles = triangulate(list(range(len(radii))), [tuple(c) for c in corners.tolist()])
    areas = areas_along(normal, corners, triangles)
    n = len(radii)
    area = 0.5 * math.sin(2 * math.pi / n) * (radii * np.roll(radii, -1)).sum()
    assert len(triangles) == n - 2
    # All turn as the polygon does, and they make up its area: no overlap, no gap.
    assert areas.min() > -1e-12
    assert areas.sum() == pytest.approx(area, abs=1e-12)


def test_names_are_kept_and_a_convex_polygon_is_a_fan():
    corners = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.5, 1.5, 0.0), (0.0, 1.0, 0.0)]
    assert triangulate([7, 9, 8, 2, 1], corners) == [(7, 9, 8), (7, 8, 2), (7, 2, 1)]


def test_an_arrow_head_is_not_cut_across_its_notch():
    corners = [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.25, 0.0), (-1.0, 1.0, 0.0)]
    for shift in range(4):
        names = [(k + shift) % 4 for k in range(4)]
        triangles = triangulate(names, [corners[k] for k in names])
        assert all({0, 2} <= set(triangle) for triangle in triangles)


@pytest.mark.parametrize('inner', [1.0, 0.5])
def test_a_face_of_8000_corners_is_cut_as_any_other(inner):
    """Each corner was held against all the others, for each triangle: 17 s, or without end."""
    radii = np.tile([1.0, inner], 4000)
    corners, normal = star(radii, 0.5)
    triangles = triangulate(list(range(len(radii))), [tuple(c) for c in corners.tolist()])
    areas = areas_along(normal, corners, triangles)
    assert len(triangles) == len(radii) - 2
    assert areas.min() > -1e-12
    assert areas.sum() == pytest.approx(4000 * math.sin(2 * math.pi / 8000) * inner)


def test_large_degenerate_polygons_end_too():
    line = [(float(k), 0.0, 0.0) for k in range(8000)]
    assert len(triangulate(list(range(8000)), line)) == 7998


def test_degenerate_polygons_still_end():
    line = [(float(k), 0.0, 0.0) for k in range(6)]
    assert len(triangulate(list(range(6)), line)) == 4
    point = [(0.0, 0.0, 0.0)] * 5
    assert len(triangulate(list(range(5)), point)) == 3
