"""STL files, binary and text, whole or refused."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import InMemoryMesh, MeshFileError
from drake_geom_ros.geometry.meshes.source import remarks_on, surface


def read(content):
    return surface(InMemoryMesh(mesh_file=MemoryFile(content, '.stl', 'box')), np.ones(3))


def binary(header=b'', told=12):
    facets = np.zeros(12, dtype=[('n', '<f4', 3), ('v', '<f4', (3, 3)), ('a', '<u2')])
    facets['v'] = BOX[SIDES]
    return header.ljust(80) + np.uint32(told).tobytes() + facets.tobytes()


def facet(corners):
    lines = [f'vertex {x:g} {y:g} {z:g}' for x, y, z in corners]
    return '\n'.join(['facet normal 0 0 0', 'outer loop', *lines, 'endloop', 'endfacet', ''])


def solid(corners, name='a vertex of solid'):
    return f'solid {name}\n{"".join(map(facet, corners))}endsolid {name}\n'


@pytest.mark.parametrize(
    'content',
    [
        binary(),
        binary(b'solid made by a program that begins like text'),
        solid(BOX[SIDES]),
        solid(BOX[SIDES]).upper(),
        '\ufeff' + solid(BOX[SIDES]),
        solid(BOX[SIDES]).replace('\n', '\r\n  \t'),
        solid(BOX[SIDES][:5]) + '\n' + solid(BOX[SIDES][5:], ''),
    ],
)
def test_all_triangles_are_read(content):
    vertices, triangles = read(content)
    np.testing.assert_array_equal(vertices[triangles], BOX[SIDES])


@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (binary()[:-50], 'tells of 12 triangles, and 11 are found in 634 bytes: it is truncated'),
        (binary()[:-1], 'tells of 12 triangles, and 11 are found'),
        (binary(told=0), 'tells of 0 triangles, and 12 are found'),
        (binary(b'solid of a program')[:-50], 'it is truncated'),
        (binary(told=0)[:84], 'no triangles'),
        (binary()[:40], '40 bytes'),
        (b'', 'it is empty'),
        (binary() + binary()[84:134] + b'  ', 'too long by 52 bytes'),
        (binary(told=11) + b'trailer', 'tells of 11 triangles, and 12 are found'),
        (solid([]), 'no triangles'),
        (solid(BOX[SIDES]).rpartition('endsolid')[0], "12 triangles are found, and no 'endsolid'"),
        # Of several solids the last one ends early: the others alone would look whole.
        (solid(BOX[SIDES][:5]) + solid(BOX[SIDES][5:]).rpartition('endsolid')[0], 'truncated'),
        (solid(BOX[SIDES]).replace('vertex 1 2 3\n', '', 1), 'has 2 vertices'),
        (solid(BOX[SIDES]).replace('vertex 1 2 3\n', 'vertex 1 2 x\n', 1), 'line '),
        (solid(BOX[[[0, 1, 3, 2]]]), 'has 4 vertices'),
        # trimesh alone ends at what is no number, here behind whole triangles.
        (solid(BOX[SIDES])[::-1].replace('3 2 1 xetrev', '3 2 x xetrev', 1)[::-1], 'is no vertex'),
        (solid(BOX[SIDES]).replace('vertex 1 2 3', 'vertex 1_0 2 3', 1), 'box'),
    ],
)
def test_what_is_truncated_or_damaged_is_refused(content, reason):
    with pytest.raises(MeshFileError, match=reason):
        read(content)


@pytest.mark.parametrize('behind', [b'  ', b'\0' * 512, b'made by a program: ' * 20])
def test_bytes_behind_the_triangles_are_left_out_with_a_remark(behind):
    mesh = InMemoryMesh(mesh_file=MemoryFile(binary() + behind, '.stl', 'box'))
    vertices, triangles = surface(mesh, np.ones(3))
    np.testing.assert_array_equal(vertices[triangles], BOX[SIDES])
    assert remarks_on(mesh) == (f'{len(behind)} bytes behind its 12 triangles are left out',)
