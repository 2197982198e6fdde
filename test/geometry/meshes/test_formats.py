"""The list of formats: each is read, and no other."""

import numpy as np
import pytest
from oracles.mesh_files import BOX, SIDES, dae, glb, gltf, off, threemf, vtk

from drake_geom_ros.geometry import Convex, MeshFileError
from drake_geom_ros.geometry.meshes._formats import FORMATS, parse_mesh
from drake_geom_ros.geometry.meshes._obj_file import obj_text
from drake_geom_ros.geometry.meshes.source import surface

STL = 'solid box\n' + ''.join(
    'facet normal 0 0 0\nouter loop\n'
    + ''.join(f'vertex {x:g} {y:g} {z:g}\n' for x, y, z in BOX[side])
    + 'endloop\nendfacet\n'
    for side in SIDES
) + 'endsolid box\n'  # fmt: skip
PLY = (
    'ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n'
    'property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n'
    + ''.join(f'{x:g} {y:g} {z:g}\n' for x, y, z in BOX)
    + ''.join(f'3 {a} {b} {c}\n' for a, b, c in SIDES)
)
FILES = {
    '3mf': threemf(),
    'dae': dae(),
    'glb': glb(),
    'gltf': gltf(),
    'obj': obj_text(BOX, SIDES),
    'off': off(),
    'ply': PLY,
    'stl': STL,
    'vtk': vtk(),
}
OTHERS = ['3dxml', 'stl_ascii', 'xaml', 'xyz', 'zae', 'vtu', 'fbx', 'mesh', '']


def written(folder, suffix, content):
    path = folder / f'box.{suffix}'.rstrip('.')
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(path)


def test_the_formats_are_these():
    assert tuple(FILES) == FORMATS


@pytest.mark.parametrize('kind', FORMATS)
@pytest.mark.parametrize('upper', [False, True])
def test_each_is_read(tmp_path, kind, upper):
    path = written(tmp_path, kind.upper() if upper else kind, FILES[kind])
    vertices, triangles = surface(path, np.ones(3))
    corners = vertices[triangles]
    lows, highs = [0, 0, 0], [1, 2, 3]
    if kind in ('glb', 'gltf'):
        lows, highs = [0, -3, 0], [1, 0, 2]
    assert corners.min(axis=(0, 1)).tolist() == lows
    assert corners.max(axis=(0, 1)).tolist() == highs
    volume = (corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(6.0)


@pytest.mark.parametrize('kind', OTHERS)
def test_any_other_is_refused_with_the_list(tmp_path, kind):
    path = written(tmp_path, kind, 'OFF\n0 0 0\n')
    with pytest.raises(
        MeshFileError, match='3mf, dae, glb, gltf, obj, off, ply, stl, vtk'
    ) as told:
        surface(path, np.ones(3))
    assert repr(kind) in str(told.value)
    with pytest.raises(MeshFileError, match='3mf, dae, glb, gltf, obj, off, ply, stl, vtk'):
        Convex(path).GetConvexHull()


@pytest.mark.parametrize('kind', FORMATS)
@pytest.mark.parametrize('content', ['', 'nonsense', '{}', '<a/>', '\0' * 200])
def test_content_of_no_format_is_refused(tmp_path, kind, content):
    with pytest.raises(MeshFileError, match=r'box\.'):
        surface(written(tmp_path, kind, content), np.ones(3))


@pytest.mark.parametrize('kind', [kind for kind in FORMATS if kind != 'obj'])
@pytest.mark.parametrize('part', [0.3, 0.6, 0.9, 0.99])
def test_a_file_that_ends_early_is_refused(tmp_path, kind, part):
    """All but .obj, which has neither counts nor an end."""
    content = FILES[kind]
    with pytest.raises(MeshFileError):
        surface(written(tmp_path, kind, content[: int(part * len(content))]), np.ones(3))


@pytest.mark.parametrize('kind', FORMATS)
@pytest.mark.parametrize(
    ('content', 'reason'),
    [
        (b'', 'it is empty'),
        (b'version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 9\n', 'git lfs pull'),
        (b'<!DOCTYPE html><html>404</html>', 'a web page'),
    ],
)
def test_what_stands_for_a_file_is_told_for_what_it_is(kind, content, reason):
    with pytest.raises(MeshFileError, match=rf"'arm.{kind}' cannot be read: .*{reason}"):
        parse_mesh(content, kind, f'arm.{kind}')
