"""What a refined file of tetrahedra has: read again, it is the refined mesh, to the bit."""

import re

import numpy as np
import pytest
from oracles.mesh_files import vtk

from drake_geom_ros.common import MemoryFile
from drake_geom_ros.geometry import (
    InMemoryMesh,
    Mesh,
    MeshSource,
    RefineVolumeMesh,
    RefineVolumeMeshIntoVtkFileContents,
    VolumeMesh,
)

# Two tetrahedra that share a face; all corners are on the boundary. No decimal is exact.
POINTS = np.array([[0, 0, 0], [1, 0, 0.1], [0, 1 / 3, 0], [0.1, 0.2, 1], [0.3, 0.1, -np.pi]])
ROWS = [[0, 1, 2, 3], [0, 2, 1, 4]]


def in_memory(text, extension='.vtk'):
    return MeshSource(InMemoryMesh(mesh_file=MemoryFile(text, extension, 'body')))


def read(text):
    mesh = Mesh(in_memory(text).in_memory()).volume_mesh()
    return mesh.vertex_array().tolist(), mesh.element_array().tolist()


@pytest.mark.parametrize('in_a_file', [True, False])
def test_the_file_is_read_as_the_refined_mesh(tmp_path, in_a_file):
    text = vtk(POINTS, ROWS)
    source = in_memory(text)
    if in_a_file:
        (tmp_path / 'body.vtk').write_text(text)
        source = MeshSource(tmp_path / 'body.vtk')
    found = RefineVolumeMeshIntoVtkFileContents(mesh_source=source)
    refined = RefineVolumeMesh(VolumeMesh.FromArrays(ROWS, POINTS))
    assert refined.num_elements() > len(ROWS)
    assert read(found) == (refined.vertex_array().tolist(), refined.element_array().tolist())
    assert RefineVolumeMeshIntoVtkFileContents(in_memory(found)) == found


def test_pydrake_reads_it_and_finds_nothing_to_refine():
    theirs = pytest.importorskip('pydrake.geometry', exc_type=ImportError)
    files = pytest.importorskip('pydrake.common', exc_type=ImportError)

    def refined(text):
        file = files.MemoryFile(text, '.vtk', 'body')
        source = theirs.MeshSource(theirs.InMemoryMesh(mesh_file=file))
        return theirs.RefineVolumeMeshIntoVtkFileContents(source)

    ours = RefineVolumeMeshIntoVtkFileContents(in_memory(vtk(POINTS, ROWS)))
    again, own = refined(ours), refined(vtk(POINTS, ROWS))
    cells = re.compile(r'CELLS (\d+) \d+')
    counts = {cells.search(text)[1] for text in (ours, again, own)}
    assert len(counts) == 1
    both = (np.sort(read(text)[0], axis=0) for text in (ours, again))
    np.testing.assert_allclose(*both, rtol=0, atol=1e-8)  # it writes eight decimals


@pytest.mark.parametrize(
    ('source', 'words'),
    [
        (in_memory('v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n', '.obj'), 'is no .vtk file'),
        (in_memory('# vtk DataFile Version 3.0\n'), 'third line must be ASCII'),
        (in_memory(vtk(POINTS, [[1, 0, 2, 3]])), 'is inside out'),
        (MeshSource('/nowhere/body.vtk'), '/nowhere/body.vtk'),
        ('body.vtk', 'MeshSource'),
    ],
)
def test_what_cannot_be_refined_is_refused_by_its_name(source, words):
    with pytest.raises((RuntimeError, TypeError), match=words):
        RefineVolumeMeshIntoVtkFileContents(source)
