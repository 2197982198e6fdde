"""Shape messages as plain objects: no message class, no ROS."""

import array
import math
from types import SimpleNamespace as Plain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_geom_ros import geometry
from drake_geom_ros.live.conversions import shapes
from drake_geom_ros.live.conversions.file_access import FileAccess

FILES = FileAccess([])
TETRAHEDRON = [0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
FACES = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]
lengths = st.floats(1e-3, 1e3)


def mesh(uri='', **fields):
    return Plain(
        **{'type': 8, 'mesh_uri': uri, 'dimensions': [], 'vertices': [], 'triangles': [], **fields}
    )


SHAPES = [
    ('Sphere', 1, 1),
    ('Box', 2, 3),
    ('Capsule', 3, 2),
    ('Cylinder', 4, 2),
    ('Ellipsoid', 5, 3),
    ('HalfSpace', 6, 0),
]


@pytest.mark.parametrize(('name', 'number', 'count'), SHAPES)
@given(data=st.data())
def test_shapes_there_and_back(name, number, count, data):
    dimensions = data.draw(st.lists(lengths, min_size=count, max_size=count))
    message = Plain(type=number, dimensions=dimensions)
    shape = shapes.shape_from_message(message, FILES)
    assert shape == getattr(geometry, name)(*dimensions)
    filled = Plain()
    shapes.fill_shape(filled, shape)
    assert (filled.type, list(filled.dimensions)) == (number, dimensions)


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (Plain(type=1, dimensions=[]), 'Sphere takes: radius'),
        (Plain(type=2, dimensions=[1.0]), 'Box takes: width, depth, height'),
        (Plain(type=6, dimensions=[1.0]), 'HalfSpace takes: none'),
        (Plain(type=1, dimensions=[math.nan]), 'radius'),
        (Plain(type=0, dimensions=[]), 'type is 0'),
        (mesh(''), 'both empty'),
        (mesh('/ball.obj', vertices=TETRAHEDRON), 'both given'),
        (mesh('ball.obj'), 'not an absolute path'),
        (mesh('/nowhere/ball.obj'), 'outside'),
        (mesh('ftp://host/ball.obj'), 'scheme'),
        (mesh('/nowhere/ball.obj', dimensions=[1.0, 2.0]), 'one scale'),
        (mesh(vertices=TETRAHEDRON), 'triangles is empty'),
        (mesh(vertices=TETRAHEDRON[:-1], triangles=FACES), '11 numbers'),
        (mesh(vertices=TETRAHEDRON, triangles=FACES[:-1]), '11 numbers'),
        (mesh(vertices=TETRAHEDRON, triangles=[0, 1, 4]), '4 vertices'),
        (mesh(vertices=[math.nan, *TETRAHEDRON[1:]], triangles=FACES), 'finite'),
        (mesh(vertices=TETRAHEDRON, triangles=FACES, dimensions=[0.0]), 'scale'),
    ],
)
def test_shapes_that_are_none_are_refused(message, words):
    with pytest.raises(RuntimeError, match=words):
        shapes.shape_from_message(message, FILES)


def test_meshes_by_file(tmp_path):
    files = FileAccess([str(tmp_path)])
    path = tmp_path / 'tetra.obj'
    path.write_text('v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n')
    for uri in (str(path), f'file://{path}'):
        message = mesh(uri, type=7, dimensions=[2.0])
        shape = shapes.shape_from_message(message, files)
        assert shape == geometry.Convex(str(path), 2.0)
    filled = mesh()
    shapes.fill_shape(filled, shapes.shape_from_message(mesh(uri), files))
    assert (filled.type, filled.mesh_uri, list(filled.dimensions)) == (8, str(path), [1.0])


@pytest.mark.parametrize('number', [7, 8])
@pytest.mark.parametrize('scale', [[1.0], [2.0, 3.0, -4.0]])
def test_meshes_in_the_message_there_and_back(number, scale):
    message = mesh(type=number, vertices=TETRAHEDRON, triangles=FACES, dimensions=scale)
    shape = shapes.shape_from_message(message, FILES)
    assert type(shape) is (geometry.Convex if number == 7 else geometry.Mesh)
    vertices, triangles = shape.hull_surface()
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    volume = np.prod(np.abs(np.broadcast_to(scale, 3))) / 6
    assert (a * np.cross(b - a, c - a)).sum() / 6 == pytest.approx(volume)
    filled = mesh(vertices=array.array('d'))
    shapes.fill_shape(filled, shape)
    assert filled.mesh_uri == ''
    assert list(filled.vertices) == TETRAHEDRON
    assert list(filled.triangles) == FACES
    assert list(filled.dimensions) == scale


def test_a_convex_needs_no_triangles():
    message = mesh(type=7, vertices=TETRAHEDRON)
    assert len(shapes.shape_from_message(message, FILES).hull_surface()[1]) == 4
