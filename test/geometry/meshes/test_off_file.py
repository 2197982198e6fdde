"""OFF files: faces of any number of corners, whole or refused."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, off

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import InMemoryMesh, MeshFileError
from drake_geom_ros.geometry.meshes.source import surface


def read(content):
    mesh = InMemoryMesh(mesh_file=MemoryFile(content, '.off', 'box'))
    return surface(mesh, np.ones(3))


@pytest.mark.parametrize(
    'content',
    [
        off(),
        off().replace('OFF\n', 'OFF '),
        '# a comment\n\n' + off().replace('\n', '  # of a line\n'),
        '\ufeff' + off(header='COFF').replace('.0\n', '.0 1 0 0 1\n'),
    ],
)
def test_all_triangles_are_read(content):
    vertices, triangles = read(content)
    np.testing.assert_array_equal(vertices, BOX)
    np.testing.assert_array_equal(triangles, SIDES)


def test_a_face_with_a_notch_is_cut_into_triangles_inside_it():
    """A fan about its first corner would reach outside."""
    arrow = [[0, 0, 0], [2, 1, 0], [0, 2, 0], [1, 1, 0]]
    vertices, triangles = read(off(arrow, [[0, 1, 2, 3]]))
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    areas = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert (areas > 0.0).all()
    assert areas.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (off(counts='8 13 0'), 'states 8 vertices and 13 faces, and 20 lines follow'),
        (off(counts='9 12 0'), 'states 9 vertices'),
        (off(counts='8'), 'no numbers of vertices and faces'),
        (off(header='STOFF'), "begins with 'STOFF'"),
        (off(BOX, [[0, 1, 8]]), 'has the vertex 8; there are 8'),
        (off(BOX, [[0, 1, -1]]), 'has the vertex 1'),
        (off(BOX, [[0, 1]]), '3 or more'),
        (off().replace('3 0 1 3', '4 0 1 3'), "'4 0 1 3' has no 4 vertices"),
        (off().replace('3.0', 'three'), 'could not convert'),
        (off(BOX * np.nan), 'no three finite numbers'),
    ],
)
def test_what_is_damaged_is_refused(content, reason):
    with pytest.raises(MeshFileError, match=reason):
        read(content)
