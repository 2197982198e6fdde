"""Files that trimesh wrote, nothing opened beside them, and hulls without idle vertices."""

import ast
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from oracles.solids import surface_of

from drake_geom_ros.geometry import MeshData, MeshFileError
from drake_geom_ros.geometry.meshes._library import tight_box
from drake_geom_ros.geometry.meshes.source import MeshFile, hull_of, hull_surface, surface
from truth.bodies.random_bodies import random_rotation

ROOT = Path(__file__).parents[3]
ONES = np.ones(3)


def mesh_of(name):
    data = surface_of(name)
    return trimesh.Trimesh(data.vertices, data.triangles, process=False)


def volume_of(filename):
    vertices, triangles = surface(str(filename), ONES)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return float((a * np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize('kind', ['obj', 'stl', 'ply', 'glb', 'dae'])
def test_a_format_is_read(tmp_path, kind):
    path = tmp_path / f'mesh.{kind}'
    mesh_of('L').export(path)
    assert volume_of(path) == pytest.approx(3.0, abs=1e-6)
    vertices, _ = surface(str(path), ONES)
    # glTF has its y axis up.
    assert vertices.min(axis=0).tolist() == ([0, -1, 0] if kind == 'glb' else [0, 0, 0])
    assert vertices.max(axis=0).tolist() == ([2, 0, 2] if kind == 'glb' else [2, 2, 1])


def test_text_formats_are_read(tmp_path):
    (tmp_path / 'mesh.stl').write_text(mesh_of('L').export(file_type='stl_ascii'))
    (tmp_path / 'mesh.ply').write_bytes(mesh_of('L').export(file_type='ply', encoding='ascii'))
    assert volume_of(tmp_path / 'mesh.stl') == pytest.approx(3.0, abs=1e-6)
    assert volume_of(tmp_path / 'mesh.ply') == pytest.approx(3.0, abs=1e-6)


def scene():
    """Two Ls, one 10 m along x and turned on its back."""
    found = trimesh.Scene()
    turned = trimesh.transformations.rotation_matrix(np.pi, [1, 0, 0])
    turned[0, 3] = 10.0
    found.add_geometry(mesh_of('L'))
    found.add_geometry(mesh_of('L'), transform=turned)
    return found


def test_a_scene_is_flattened_with_its_transforms(tmp_path):
    scene().export(tmp_path / 'scene.glb')
    vertices, _ = surface(str(tmp_path / 'scene.glb'), ONES)
    assert vertices.min(axis=0) == pytest.approx([0, -1, -2], abs=1e-6)
    assert vertices.max(axis=0) == pytest.approx([12, 1, 2], abs=1e-6)
    assert volume_of(tmp_path / 'scene.glb') == pytest.approx(6.0, abs=1e-5)


def test_gltf_is_read_with_its_buffers_embedded_or_beside_it(tmp_path):
    files = scene().export(file_type='gltf', embed_buffers=True)
    (tmp_path / 'embedded.gltf').write_bytes(files['model.gltf'])
    assert volume_of(tmp_path / 'embedded.gltf') == pytest.approx(6.0, abs=1e-5)
    for name, content in scene().export(file_type='gltf').items():
        (tmp_path / name).write_bytes(content)
    assert 'uri' in json.loads((tmp_path / 'model.gltf').read_text())['buffers'][0]
    assert volume_of(tmp_path / 'model.gltf') == pytest.approx(6.0, abs=1e-5)


OPENED = """
import sys
opened = []
sys.addaudithook(lambda event, args: opened.append(str(args[0])) if event == 'open' else None)
import numpy as np
from drake_geom_ros.geometry.meshes.source import hull_surface
for path in sys.argv[1:]:
    try:
        hull_surface(path, np.ones(3))
    except Exception as error:
        print(type(error).__name__)
print(sorted({path for path in opened if 'treasure' in path}))
"""


@pytest.mark.processes
def test_nothing_but_the_mesh_is_opened(tmp_path):
    for name in ('treasure.mtl', 'treasure.png', 'treasure.bin'):
        (tmp_path / name).write_text('newmtl a\nmap_Kd treasure.png\n')
    lines = [f'v {x} {y} {z}' for x, y, z in np.ndindex(2, 2, 2)]
    faces = ['f 1 2 4 3', 'f 5 7 8 6', 'f 1 5 6 2', 'f 3 4 8 7', 'f 1 3 7 5', 'f 2 6 8 4']
    text = '\n'.join(['mtllib treasure.mtl', *lines, 'usemtl a', *faces])
    (tmp_path / 'a.obj').write_text(text)
    mesh = mesh_of('L').export(file_type='ply', encoding='ascii').decode()
    header = 'format ascii 1.0\n'
    assert header in mesh
    mesh = mesh.replace(header, f'{header}comment TextureFile treasure.png\n')
    (tmp_path / 'a.ply').write_text(mesh)
    gltf = json.loads(scene().export(file_type='gltf')['model.gltf'])
    for buffer in gltf['buffers']:
        buffer['uri'] = 'treasure.bin'
    gltf['images'] = [{'uri': 'treasure.png'}]
    (tmp_path / 'a.gltf').write_text(json.dumps(gltf))
    paths = [str(tmp_path / f'a.{kind}') for kind in ('obj', 'ply', 'gltf')]
    found = subprocess.run(
        [sys.executable, '-c', OPENED, *paths],
        cwd=ROOT, capture_output=True, text=True, timeout=800,
        env={**os.environ, 'PYTHONPATH': str(ROOT)},
    )  # fmt: skip
    # A buffer that is no buffer: it holds numbers of the mesh, and materials and images do not.
    first, second = found.stdout.split('\n')[:2]
    assert first == 'MeshFileError', found.stderr
    assert {Path(path).name for path in ast.literal_eval(second)} == {'treasure.bin'}


def test_two_paths_of_the_same_content_share(tmp_path):
    mesh_of('U').export(tmp_path / 'a.ply')
    (tmp_path / 'b.ply').write_bytes((tmp_path / 'a.ply').read_bytes())
    one, other = MeshFile(str(tmp_path / 'a.ply')), MeshFile(str(tmp_path / 'b.ply'))
    assert one == other
    assert hull_of(one)[0] is hull_of(other)[0]
    mesh_of('L').export(tmp_path / 'b.ply')
    assert one != MeshFile(str(tmp_path / 'b.ply'))


def test_a_file_that_changes_while_it_is_read_is_refused(tmp_path):
    mesh_of('U').export(tmp_path / 'a.ply')
    source = MeshFile(str(tmp_path / 'a.ply'))
    mesh_of('L').export(tmp_path / 'a.ply')
    with pytest.raises(MeshFileError, match='changed'):
        source.content()


@pytest.mark.parametrize('turn', range(6))
def test_a_hull_has_no_vertices_within_faces_and_edges(turn):
    rng = np.random.default_rng(turn)
    R = random_rotation(rng) if turn else np.eye(3)
    grid = np.array(list(np.ndindex(6, 6, 6)), dtype=float) / 5
    points = grid[rng.permutation(len(grid))] @ R.T + 3.0
    vertices, triangles = hull_surface(MeshData(points), ONES)
    corners = np.array(list(np.ndindex(2, 2, 2)), dtype=float) @ R.T + 3.0
    assert sorted(vertices.round(9).tolist()) == sorted(corners.round(9).tolist())
    assert len(triangles) == 12


def test_a_round_hull_keeps_all_its_vertices():
    ball = trimesh.creation.icosphere(subdivisions=3)
    assert len(hull_surface(MeshData(ball.vertices), ONES)[0]) == len(ball.vertices)


@pytest.mark.filterwarnings('error')
def test_hulls_of_points_in_lines_have_no_warning():
    """On an edge of a hull many points are in a line, and triangles there may have no area."""
    rng = np.random.default_rng(6)
    for _ in range(20):
        corners = rng.normal(size=(6, 3))
        shares = rng.random((40, 1))
        i, j = rng.integers(0, 6, (2, 40))
        points = np.vstack((corners, corners[i] + shares * (corners[j] - corners[i])))
        vertices, triangles = hull_of(MeshData(points, []))
        assert len(vertices) <= 6
        assert len(triangles) == 2 * len(vertices) - 4


@pytest.mark.parametrize('axes', [np.eye(3), -np.eye(3), np.eye(3)[[1, 0, 2]]])
def test_the_axes_of_a_box_are_a_rotation_whatever_trimesh_returns(axes, monkeypatch):
    placed = np.eye(4)
    placed[:3, :3] = axes
    monkeypatch.setattr(trimesh.bounds, 'oriented_bounds', lambda points: (placed, np.ones(3)))
    turned = tight_box(np.zeros((3, 3)))
    assert np.linalg.det(turned) == pytest.approx(1.0)
    assert np.abs(turned).tolist() == np.abs(axes).T.tolist()
