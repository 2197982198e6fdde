"""Flat collision meshes of robots: refused, given a thickness, or left out."""

import numpy as np
import pytest

from drake_geom_ros.geometry import Convex, MeshData, MeshFileError, Role, SceneGraph
from drake_geom_ros.geometry.shapes.thickening import thickened
from drake_geom_ros.scene_files import SceneFileError, load_scene, read_scene

SHEET = 'v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n'
WEDGE = SHEET + 'v 1 0.5 1\nf 1 2 5\n'
URDF = """<robot name="r">
<link name="a"><collision name="sheet"><geometry><mesh filename="sheet.obj" scale="1 3 1"/>
</geometry></collision><collision name="wedge"><geometry><mesh filename="wedge.obj"/></geometry>
</collision></link></robot>"""
SDF = """<sdf version="1.9"><model name="r"><link name="a">
<collision name="sheet"><geometry><mesh><uri>sheet.obj</uri><scale>1 3 1</scale></mesh></geometry>
<surface><contact><collide_bitmask>1</collide_bitmask></contact></surface></collision>
<collision name="wedge"><geometry><mesh><uri>wedge.obj</uri></mesh></geometry></collision>
</link></model></sdf>"""


@pytest.fixture(params=['urdf', 'sdf'])
def folder(tmp_path, request):
    (tmp_path / 'sheet.obj').write_text(SHEET)
    (tmp_path / 'wedge.obj').write_text(WEDGE)
    (tmp_path / 'robot').write_text(URDF if request.param == 'urdf' else SDF)
    return tmp_path


def scene_with(folder, key):
    path = folder / 'scene.yaml'
    path.write_text(f'robots:\n- name: r\n  urdf: robot\n{key}\n')
    return path


def test_a_flat_mesh_is_refused_and_the_key_is_named(folder):
    with pytest.raises(SceneFileError, match=r'robot:\d+:.*lie in a plane.*key `flat_meshes`'):
        load_scene(scene_with(folder, ''), SceneGraph())


def test_a_flat_mesh_gets_a_thickness(folder):
    scene_graph = SceneGraph()
    path = scene_with(folder, '  flat_meshes: {thickness: 0.01}')
    warning = '1 flat mesh, 0.01 m thick, and counted as their hulls: a/sheet'
    with pytest.warns(UserWarning, match=warning):
        load_scene(path, scene_graph)
    (sheet, wedge) = read_scene(path).geometries
    assert isinstance(sheet.shape, Convex)
    vertices, _ = sheet.shape.hull_surface()
    np.testing.assert_allclose(vertices.min(axis=0), [0, 0, -0.005], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(vertices.max(axis=0), [2, 3, 0.005], rtol=0.0, atol=1e-15)
    assert wedge.shape.filename().endswith('wedge.obj')
    assert scene_graph.model_inspector().NumGeometriesWithRole(Role.kProximity) == 2


def test_a_flat_mesh_is_left_out_with_a_warning(folder):
    scene_graph = SceneGraph()
    with pytest.warns(UserWarning, match='1 flat mesh, left out, so no query sees them: a/sheet'):
        load_scene(scene_with(folder, '  flat_meshes: leave_out'), scene_graph)
    assert scene_graph.model_inspector().NumGeometriesWithRole(Role.kProximity) == 1


@pytest.mark.parametrize(
    ('value', 'fault'),
    [
        ('{thickness: 0}', r'flat_meshes.thickness: 0 must be > 0'),
        ('{}', 'missing `thickness`'),
        ('keep', "'keep': it must be leave_out, or a mapping"),
        ('0.01', r'0\.01 must be text .* or a mapping'),
    ],
)
def test_a_faulty_key_is_refused(folder, value, fault):
    with pytest.raises(SceneFileError, match=fault):
        read_scene(scene_with(folder, f'  flat_meshes: {value}'))


def test_a_saved_robot_takes_no_key(folder):
    with pytest.raises(SceneFileError, match='flat_meshes: has no effect with `loaded: true`'):
        read_scene(scene_with(folder, '  flat_meshes: leave_out\n  loaded: true'))


@pytest.mark.parametrize('seed', range(4))
def test_the_hull_is_as_thick_as_asked_whatever_the_plane(seed):
    """The support width along the normal is the thickness, and others grow by no more."""
    rng = np.random.default_rng(seed)
    R = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    flat = np.column_stack((rng.normal(size=(8, 2)), np.zeros(8)))
    vertices = flat @ R.T + rng.normal(size=3)
    made = thickened(Convex.FromMeshData(MeshData(vertices)), 1e-3)
    points, _ = made.hull_surface()
    heights = (points - vertices[0]) @ R[:, 2]
    np.testing.assert_allclose([heights.min(), heights.max()], [-5e-4, 5e-4], rtol=0.0, atol=1e-12)
    for direction in rng.normal(size=(20, 3)):
        direction -= (direction @ R[:, 2]) * R[:, 2]
        assert (points @ direction).max() == pytest.approx((vertices @ direction).max(), abs=1e-12)


def test_a_line_is_thick_across_in_both_directions():
    made = thickened(Convex.FromMeshData(MeshData([[0, 0, 0], [1, 0, 0], [3, 0, 0]])), 0.2)
    points, _ = made.hull_surface()
    np.testing.assert_allclose(np.ptp(points, axis=0)[0], 3.0, rtol=0.0, atol=1e-12)
    sides = np.linalg.norm(points[:, 1:], axis=1)
    np.testing.assert_allclose(sides, 0.1 * np.sqrt(2.0), rtol=0.0, atol=1e-12)


def test_a_mesh_with_a_volume_is_not_flat():
    wedge = MeshData([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1e-6]])
    assert thickened(Convex.FromMeshData(wedge), 1.0) is None
    flat = Convex.FromMeshData(MeshData([[0, 0, 0], [1, 0, 0], [0, 1, 0]]))
    with pytest.raises(MeshFileError, match='lie in a plane'):
        flat.hull_surface()
