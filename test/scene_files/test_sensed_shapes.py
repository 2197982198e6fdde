"""Maps in scene files: of files beside them, written out, saved, and what is refused."""

import re

import numpy as np
import pytest

from drake_geom_ros.geometry import OccupiedCells, PointCloud, Role, SceneGraph
from drake_geom_ros.scene_files import SceneFileError, load_scene, read_scene, save_scene
from drake_geom_ros.sensed_maps import MapFile, map_bytes

POINTS = np.array([[0.02, 0.01, 0.03], [0.03, 0.04, 0.01], [1.0, -2.0, 3.0]])


@pytest.fixture
def folder(tmp_path):
    (tmp_path / 'a.bt').write_bytes(map_bytes(MapFile(POINTS), '.bt', 0.05))
    for suffix in ('.pcd', '.ply', '.xyz', '.npy'):
        (tmp_path / f'a{suffix}').write_bytes(map_bytes(MapFile(POINTS), suffix))
    (tmp_path / 'bad.bt').write_bytes(b'# Octomap OcTree binary file\n')
    return tmp_path


def scene(folder, shape, roles=''):
    path = folder / 'scene.yaml'
    path.write_text(f'sources: [s]\ngeometries:\n- {{name: m, shape: {{{shape}}}{roles}}}\n')
    return path


def shape_of(folder, shape):
    return read_scene(scene(folder, shape)).geometries[0].shape


def test_cells_are_read_from_files_of_cells_and_of_points(folder):
    cells = shape_of(folder, 'type: occupied_cells, uri: a.bt')
    assert isinstance(cells, OccupiedCells)
    assert cells.resolution() == 0.05
    assert cells.count() == 2
    for suffix in ('pcd', 'ply', 'xyz', 'npy'):
        text = f'type: occupied_cells, uri: a.{suffix}, resolution: 0.05'
        assert shape_of(folder, text) == cells
    assert shape_of(folder, 'type: occupied_cells, uri: a.bt, resolution: 10').count() == 2


def test_clouds_are_read_and_thinned(folder):
    cloud = shape_of(folder, 'type: point_cloud, uri: a.npy, radius: 0.01')
    assert isinstance(cloud, PointCloud)
    assert cloud.positions().tolist() == POINTS.tolist()
    thin = shape_of(folder, 'type: point_cloud, uri: a.npy, radius: 0.05, resolution: 0.05')
    assert thin.count() == 2
    of_cells = shape_of(folder, 'type: point_cloud, uri: a.bt, radius: 0.05')
    assert of_cells.positions().tolist() == thin.positions().tolist()


@pytest.mark.parametrize('resolution', [0.02, 0.05, 1.0 / 3.0])
def test_the_least_radius_that_is_told_holds_what_was_measured(folder, resolution):
    points = np.random.default_rng(1).uniform(-2.0, 2.0, (500, 3))
    corners = resolution * np.indices((2, 2, 2)).reshape(3, -1).T + 1e-12
    (folder / 'a.npy').write_bytes(map_bytes(MapFile(np.vstack((points, corners))), '.npy'))
    text = f'type: point_cloud, uri: a.npy, resolution: {resolution!r}, radius: '
    with pytest.raises(SceneFileError, match=r'radius is .* at least') as caught:
        shape_of(folder, f'{text}{0.866 * resolution!r}')
    least = re.search(r'at least (\S+) m', str(caught.value))[1]
    cloud = shape_of(folder, text + least)
    assert cloud.radius() <= 0.868 * resolution
    for point in np.vstack((points, corners)):
        assert np.linalg.norm(cloud.positions() - point, axis=1).min() <= cloud.radius()


@pytest.mark.parametrize('suffix', ['.pcd', '.ply', '.xyz', '.npy'])
@pytest.mark.parametrize(
    'shape', ['type: point_cloud, radius: 0.1', 'type: occupied_cells, resolution: 0.1']
)
def test_points_that_are_not_finite_are_told(folder, shape, suffix):
    points = np.vstack((POINTS, [[np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]]))
    (folder / f'b{suffix}').write_bytes(map_bytes(MapFile(points), suffix))
    (warning,) = read_scene(scene(folder, f'{shape}, uri: b{suffix}')).warnings
    assert f'b{suffix}' in warning
    assert warning.endswith("' are not finite and left out")
    assert 'geometries[0].shape: 2 points of' in warning
    assert not read_scene(scene(folder, f'{shape}, uri: a{suffix}')).warnings
    with pytest.warns(UserWarning, match='2 points of'):
        load_scene(scene(folder, f'{shape}, uri: b{suffix}'), SceneGraph())


@pytest.mark.parametrize('count', [3, 2500])
def test_what_is_saved_is_loaded_with_its_margin_and_to_the_bit(folder, count):
    points = np.random.default_rng(count).normal(size=(count, 3))
    (folder / 'a.npy').write_bytes(map_bytes(MapFile(points), '.npy'))
    roles = ', roles: {proximity: {map: {margin: 0.02}}}'
    for text in (
        'type: occupied_cells, uri: a.npy, resolution: 0.01',
        'type: point_cloud, uri: a.npy, radius: 0.01',
    ):
        graph = SceneGraph()
        load_scene(scene(folder, text, roles), graph)
        (saved,) = read_scene(save_scene(graph)).geometries
        (before,) = read_scene(scene(folder, text, roles)).geometries
        assert saved.shape == before.shape
        assert saved.roles[Role.kProximity].GetProperty('map', 'margin') == 0.02


@pytest.mark.parametrize(
    ('shape', 'reason'),
    [
        ('type: occupied_cells, uri: a.xyz', 'was not given'),
        ('type: occupied_cells, uri: a.bt, resolution: 0.01', 'finer than the map'),
        ('type: occupied_cells, uri: bad.bt', 'bad.bt'),
        ('type: occupied_cells, uri: none.bt', 'no file'),
        ('type: occupied_cells, uri: scene.yaml, resolution: 1', 'suffix'),
        ('type: occupied_cells, centres: [[0, 0, 0]]', 'resolution'),
        (
            'type: occupied_cells, resolution: 1, centres: "AAA="',
            'shape: rows of three <f8 are packed as base64',
        ),
        (
            'type: occupied_cells, resolution: 1, centres: [], uri: a.bt',
            'cannot be given together',
        ),
        ('type: mesh, vertices: [], uri: a.obj', 'cannot be given together'),
        ('type: point_cloud, uri: a.bt', 'radius'),
        ('type: point_cloud, radius: 1, positions: []', 'must be|were given'),
        ('type: point_cloud, radius: 0, uri: a.bt', 'radius'),
        ('type: point_cloud, radius: 0.0433, uri: a.bt', r'cells of 0.05 m.*at least 0.04334 m'),
    ],
)
def test_what_is_no_map_is_refused_with_its_place(folder, shape, reason):
    with pytest.raises(SceneFileError, match=reason) as caught:
        read_scene(scene(folder, shape))
    assert 'scene.yaml:3' in str(caught.value)
