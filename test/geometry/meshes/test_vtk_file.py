"""Legacy .vtk files of tetrahedra: what is read, and what is refused and why."""

import sys

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, vtk

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import Convex, InMemoryMesh, Mesh, MeshFileError
from drake_geom_ros.geometry.shapes.mesh_facts import mesh_facts

CELLS = [(*side, len(BOX)) for side in SIDES[:, ::-1].tolist()]
POINTS = [*BOX.tolist(), BOX.mean(axis=0).tolist()]


def written(folder, text):
    path = folder / 'body.vtk'
    path.write_text(text)
    return str(path)


def test_the_tetrahedra_are_those_of_the_file_and_the_surface_is_their_boundary(tmp_path):
    shape = Mesh(written(tmp_path, vtk()), 2.0)
    mesh = shape.volume_mesh()
    assert (mesh.element_array() == CELLS).all()
    assert (mesh.vertex_array() == 2.0 * np.array(POINTS)).all()
    vertices, triangles = shape.surface()
    assert (len(vertices), len(triangles)) == (8, 12)
    assert len(shape.hull_surface()[0]) == 8
    assert mesh_facts(shape).is_closed
    assert Convex(shape.filename()).GetConvexHull().num_vertices() == 8


@pytest.mark.parametrize('scale', [[1, 1, -1], [-1, -2, -3], [-1, -1, 1], 0.5])
def test_a_mirror_image_is_not_inside_out(tmp_path, scale):
    mesh = Mesh(written(tmp_path, vtk()), scale).volume_mesh()
    volume = 6.0 * abs(np.prod(np.broadcast_to(scale, 3)))
    assert mesh.CalcVolume() == pytest.approx(volume)
    assert min(map(mesh.CalcTetrahedronVolume, range(12))) > 0.0


def test_vertices_of_no_tetrahedron_are_left_out(tmp_path):
    """In pydrake such a vertex, far away, is where the pressure is the largest."""
    cells = [tuple(i + 1 for i in cell) for cell in CELLS]
    mesh = Mesh(written(tmp_path, vtk([(9, 9, 9), *POINTS], cells))).volume_mesh()
    assert (mesh.element_array() == CELLS).all()
    assert mesh.num_vertices() == 9


def test_data_of_points_and_cells_are_skipped(tmp_path):
    text = vtk() + 'POINT_DATA 9\nSCALARS heat double 1\nLOOKUP_TABLE default\n' + '0.5\n' * 9
    assert Mesh(written(tmp_path, text)).volume_mesh().num_elements() == 12


def in_version_5_1():
    lines = vtk(version='5.1').splitlines()
    at = lines.index('CELLS 12 60')
    offsets = ' '.join(map(str, range(0, 49, 4)))
    rows = [line.partition(' ')[2] for line in lines[at + 1 : at + 13]]
    lines[at : at + 13] = [
        *('CELLS 13 48', 'OFFSETS vtktypeint64', offsets, 'CONNECTIVITY vtktypeint64'),
        *rows,
    ]
    return '\n'.join(lines) + '\n'


def test_version_5_1_is_read(tmp_path):
    mesh = Mesh(written(tmp_path, in_version_5_1())).volume_mesh()
    assert (mesh.element_array() == CELLS).all()


@pytest.mark.parametrize('title', ['CELL_TYPES 3', 'DATASET POLYDATA', '', 'x' * 255])
def test_a_title_says_nothing(tmp_path, title):
    lines = vtk().splitlines()
    lines[1] = title
    for end in ('\n', '\r\n'):
        path = written(tmp_path, end.join(lines) + end)
        assert Mesh(path).volume_mesh().num_elements() == 12


def rolled(cell):
    """Return the same tetrahedron, from another vertex on."""
    a, b, c, d = cell
    return b, c, a, d


def test_a_file_in_memory_is_read_and_another_format_has_no_tetrahedra():
    shape = Mesh(InMemoryMesh(mesh_file=MemoryFile(vtk(), '.vtk', 'body')))
    assert shape.volume_mesh().num_elements() == 12
    box = Mesh.FromMeshData(shape.mesh_data())
    assert box.volume_mesh() is None


def turned(k):
    cells = list(CELLS)
    cells[k] = (cells[k][1], cells[k][0], *cells[k][2:])
    return cells


FLAT = [*CELLS, (0, 1, 2, 3)]  # four corners of a side
REFUSED = {
    'a triangle': (vtk(POINTS, [*CELLS, (0, 1, 2)], [10] * 12 + [5]), 'kind triangle; its cells'),
    'a hexahedron': (
        vtk(POINTS, [tuple(range(8))], [12]),
        'kind hexahedron; its cells must be te',
    ),
    'no cell': (vtk(POINTS, []), 'no cells|holds no mesh'),
    'inside out': (vtk(POINTS, turned(3)), 'element 3 is inside out'),
    'flat': (vtk(POINTS, FLAT), 'element 12 has no volume'),
    'no such vertex': (vtk(POINTS, [*CELLS, (0, 1, 2, 9)]), r'has vertices \[0, 1, 2, 9\]'),
    'a negative one': (vtk(POINTS, [*CELLS, (0, 1, 2, -1)]), r'has vertices \[0, 1, 2, -1\]'),
    'one twice': (vtk(POINTS, [*CELLS, CELLS[0]]), 'elements 0 and 12 are the same: vertices'),
    'one twice, turned': (vtk(POINTS, [*CELLS, rolled(CELLS[3])]), 'elements 3 and 12 are the'),
    'two on one side of a face': (
        vtk([*POINTS, 0.9 * np.array(POINTS[8]) + 0.1 * BOX[0]], [*CELLS, (*CELLS[5][:3], 9)]),
        r'elements 5 and 12 overlap: both are on one side of their face \[',
    ),
    'version 5.1 with cells of 3.0': (
        vtk(version='5.1'),
        'or in version 5.1, and no other, OFFSETS',
    ),
    'version 5.0 with cells of 5.1': (in_version_5_1().replace('5.1', '5.0'), 'and no other, OFF'),
    'a type too few': (vtk()[:-3], 'ends early: 11 cells'),
    'not a number': (vtk().replace('CELLS 12', '7 CELLS 12'), 'cannot be read|holds no mesh'),
    'not finite': (vtk([*POINTS[:8], (np.nan, 1, 1)]), 'finite'),
    'binary': (vtk().replace('ASCII', 'BINARY'), 'third line must be ASCII'),
    'xml': ('<VTKFile type="UnstructuredGrid"/>', 'as legacy files do'),
    'another set': (vtk().replace('UNSTRUCTURED_GRID', 'POLYDATA'), 'DATASET must be an UNSTR'),
}


@pytest.mark.parametrize('name', REFUSED)
@pytest.mark.parametrize('question', ['surface', 'volume_mesh', 'hull_surface'])
def test_refused_with_path_and_cause(tmp_path, name, question):
    text, reason = REFUSED[name]
    with pytest.raises(MeshFileError, match=rf'body\.vtk.*({reason})'):
        getattr(Mesh(written(tmp_path, text)), question)()


@pytest.mark.parametrize('lost', [2, 3, 5, 40, 100, 300, 500])
def test_a_file_that_ends_early_is_never_a_smaller_body(tmp_path, lost):
    with pytest.raises(MeshFileError, match=r'body\.vtk'):
        Mesh(written(tmp_path, vtk()[:-lost])).volume_mesh()


def test_without_meshio_it_is_told_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, 'meshio', None)
    with pytest.raises(MeshFileError, match=r"body\.vtk.*pip install meshio.*'volume_meshes'"):
        Mesh(written(tmp_path, vtk() + '\n\n')).surface()  # what nobody has read yet
